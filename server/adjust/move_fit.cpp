#include "server/adjust/move_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "server/adjust/part_outline.h"

namespace meshloop::adjust {
namespace {

constexpr double kCut_sigmas = 5;
constexpr std::array<double, 4> kCuts_m{0.08, 0.04, 0.02, 0};
constexpr int kRoundsOfFaces = 5;
/// Pixels: how far the outline is looked for, round by round.
constexpr std::array<int, 8> kReaches_px{24, 16, 12, 8, 6, 6, 6, 6};
/// Of one measured point of an edge.
constexpr double kOutlineSigma_px = 1;
/// Errors of neighbouring points are alike: so many count as one.
constexpr double kCorrelated = 10;
/// A direction is held when its standard deviation is below so many of the sensor's sigma.
constexpr double kHeld_sigmas = 1.5;
/// Steeper surface tells nothing: the cosine of the angle to its normal.
constexpr double kSteepest_cos = 0.1;
constexpr double kSettled_m = 1e-4;

double tukey(double residual, double cut) {
  const double share = std::min(1.0, residual * residual / (cut * cut));
  return (1 - share) * (1 - share);
}

/// Of the twist about the part's middle, rotations scaled by its radius: all six in metres.
struct Equations {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Twist pull = Twist::Zero();
  Eigen::Vector3d center;
  double radius_m;

  /// The point should move by `residual` along `direction`.
  void add(const Eigen::Vector3d& point, const Eigen::Vector3d& direction, double residual, double weight) {
    Twist row;
    row << direction, (point - center).cross(direction) / radius_m;
    information += weight * row * row.transpose();
    pull += weight * residual * row;
  }
};

/// How the part's faces lie to the loose measurements.
struct Faces {
  double seen = 0;
  double agreeing = 0;
};

Faces add_faces(const MoveScene& scene, const Part& part, const WithoutPart& without, const Pose& T_camera_node,
                std::size_t points, double cut_m, Equations& equations) {
  Faces faces;
  const Camera& camera = scene.camera();
  for (std::size_t i = 0; i < std::min(points, part.points.size()); ++i) {
    const Eigen::Vector3d p = T_camera_node * part.points[i].point;
    const Eigen::Vector3d normal = T_camera_node.linear() * part.points[i].normal;
    if (!(p.z() > 0.05)) continue;
    const double facing = -normal.dot(p) / p.norm();
    if (facing < kSteepest_cos) continue;
    const double seen = facing / p.squaredNorm();
    faces.seen += seen;
    const Eigen::Vector2d pixel = camera.project(p);
    if (!camera.contains(pixel)) continue;
    const auto x = static_cast<int>(std::floor(pixel.x() + 0.5));
    const auto y = static_cast<int>(std::floor(pixel.y() + 0.5));
    if (without.piece(x, y) == 0) continue;
    const auto z = static_cast<double>(scene.measured(x, y));
    const double sigma_m = scene.snapshot->rig->sensor.sigma_z_m(z, 0);
    const double distance = normal.dot(camera.back_project(x, y, z) - p);
    const double weight = tukey(distance, std::max(kCut_sigmas * sigma_m, cut_m));
    faces.agreeing += seen * tukey(distance, kCut_sigmas * sigma_m);
    equations.add(p, normal, distance, weight / (sigma_m * sigma_m));
  }
  return faces;
}

void add_outline(const MoveScene& scene, const std::vector<OutlinePoint>& outline, int reach_px, Equations& equations) {
  const Camera& camera = scene.camera();
  for (const auto& [p, outwards, off_px] : outline) {
    // Pixels by which the outline moves along `outwards` when the point moves by a metre.
    const Eigen::Vector2d focal{outwards.x() * camera.fx, outwards.y() * camera.fy};
    const Eigen::Vector3d gradient =
        Eigen::Vector3d{focal.x(), focal.y(), -(focal.x() * p.x() + focal.y() * p.y()) / p.z()} / p.z();
    const double px_per_m = gradient.norm();
    const double weight = tukey(off_px, reach_px + 1) * px_per_m * px_per_m / (kOutlineSigma_px * kOutlineSigma_px);
    equations.add(p, gradient / px_per_m, off_px / px_per_m, weight);
  }
}

struct Step {
  double length_m = 0;
  int free_directions = 0;
  bool slides = false;
};

// Only along directions that are held.
Step take_step(const Equations& equations, double sigma_m, Pose& T_camera_node) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver{equations.information};
  const double least = kCorrelated / (kHeld_sigmas * kHeld_sigmas * sigma_m * sigma_m);
  Step step;
  Twist twist = Twist::Zero();
  for (int i = 0; i < 6; ++i) {
    const Twist direction = solver.eigenvectors().col(i);
    if (solver.eigenvalues()[i] < least) {
      ++step.free_directions;
      step.slides = step.slides || direction.head<3>().squaredNorm() > 0.5;
      continue;
    }
    twist += direction * (direction.dot(equations.pull) / solver.eigenvalues()[i]);
  }
  step.length_m = twist.norm();
  twist.tail<3>() /= equations.radius_m;
  const Eigen::Translation3d to_center{equations.center};
  T_camera_node = to_center * exp(twist) * to_center.inverse() * T_camera_node;
  return step;
}

Equations equations_at(const Part& part, const Pose& T_camera_node) {
  Equations equations;
  equations.center = T_camera_node * part.center;
  equations.radius_m = std::max(part.radius_m, 1e-3);
  return equations;
}

double sigma_at(const MoveScene& scene, const Equations& equations) {
  return scene.snapshot->rig->sensor.sigma_z_m(std::max(equations.center.z(), 0.1), 0);
}

}  // namespace

MoveFit fit_faces(const MoveScene& scene, const Part& part, const WithoutPart& without, const Pose& start,
                  std::size_t points) {
  MoveFit fit;
  fit.T_camera_node = start;
  for (const double cut_m : kCuts_m) {
    for (int round = 0; round < kRoundsOfFaces; ++round) {
      Equations equations = equations_at(part, fit.T_camera_node);
      const Faces faces = add_faces(scene, part, without, fit.T_camera_node, points, cut_m, equations);
      fit.agreeing = faces.seen > 0 ? faces.agreeing / faces.seen : 0;
      const Step step = take_step(equations, sigma_at(scene, equations), fit.T_camera_node);
      if (step.length_m < kSettled_m) break;
    }
  }
  return fit;
}

MoveFit fit_outline(const MoveScene& scene, const Part& part, const WithoutPart& without, const Pose& start) {
  MoveFit fit;
  fit.T_camera_node = start;
  for (const int reach_px : kReaches_px) {
    Equations equations = equations_at(part, fit.T_camera_node);
    const Faces faces =
        add_faces(scene, part, without, fit.T_camera_node, part.points.size(), 0.002 * reach_px, equations);
    add_outline(scene, find_outline(scene, part, without, fit.T_camera_node, reach_px), reach_px, equations);
    fit.agreeing = faces.seen > 0 ? faces.agreeing / faces.seen : 0;
    const Step step = take_step(equations, sigma_at(scene, equations), fit.T_camera_node);
    fit.free_directions = step.free_directions;
    fit.slides = step.slides;
    if (step.length_m < kSettled_m) break;
  }
  return fit;
}

}  // namespace meshloop::adjust
