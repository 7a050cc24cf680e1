#include "server/adjust/move_starts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace meshloop::adjust {
namespace {

constexpr std::size_t kMostPieces = 4;
constexpr int kTurns = 12;
constexpr std::size_t kPoints = 200;
/// A piece shows so much of what the part showed, by area, at least and at most.
constexpr double kLeastArea = 0.3;
constexpr double kMostArea = 3;

std::vector<LoosePiece> fitting_pieces(const MoveScene& scene, const Part& part, const WithoutPart& without) {
  const double old_z = (scene.T_camera_node(part.node_position) * part.center).z();
  const double old_area = without.footprint_pixels * old_z * old_z;
  std::vector<LoosePiece> pieces;
  for (const auto& piece : without.pieces) {
    const double area = piece.pixels * piece.center_m.z() * piece.center_m.z();
    if (area > kLeastArea * old_area && area < kMostArea * old_area) pieces.push_back(piece);
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const LoosePiece& a, const LoosePiece& b) { return a.pixels > b.pixels; });
  if (pieces.size() > kMostPieces) pieces.resize(kMostPieces);
  return pieces;
}

/// Mean of what faces the camera, from the part's middle, in the camera's frame.
Eigen::Vector3d visible_middle(const Part& part, const Eigen::Matrix3d& R_camera_node, const Eigen::Vector3d& ray) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < std::min(kPoints, part.points.size()); ++i) {
    const double facing = -(R_camera_node * part.points[i].normal).dot(ray);
    if (facing <= 0) continue;
    weights += facing;
    sum += facing * (R_camera_node * (part.points[i].point - part.center));
  }
  return weights > 0 ? Eigen::Vector3d(sum / weights) : sum;
}

Pose placed(const Part& part, const Eigen::Matrix3d& R_camera_node, const LoosePiece& piece) {
  const Eigen::Vector3d center = piece.center_m - visible_middle(part, R_camera_node, piece.center_m.normalized());
  Pose pose = Pose::Identity();
  pose.linear() = R_camera_node;
  pose.translation() = center - R_camera_node * part.center;
  return pose;
}

Eigen::Matrix3d turn(const Part& part, int axis, double angle) {
  return Eigen::AngleAxisd{angle, part.axes.col(axis)}.toRotationMatrix();
}

/// The pose, turned about the part's middle by the 23 other rotations that make a cube from a cube.
std::vector<Pose> turned_as_a_cube(const Part& part, const Pose& T_camera_node) {
  std::vector<Pose> turned;
  const Eigen::Translation3d to_center{part.center};
  constexpr double kQuarter = std::numbers::pi / 2;
  for (int up = 0; up < 6; ++up) {
    // Each of the six sides comes up, and is turned by quarters.
    const Eigen::Matrix3d side = up < 4 ? turn(part, 0, up * kQuarter) : turn(part, 1, (2 * up - 9) * kQuarter);
    for (int k = 0; k < 4; ++k) {
      if (up == 0 && k == 0) continue;
      const Eigen::Matrix3d rotation = side * turn(part, 2, k * kQuarter);
      turned.push_back(T_camera_node * to_center * Pose{rotation} * to_center.inverse());
    }
  }
  return turned;
}

/// Of the part's points at a pose: those that face the camera are what was drawn.
bool shows_the_same(const MoveScene& scene, const Part& part, const DepthBuffer& drawn, const Pose& T_camera_node) {
  constexpr double kMostOthers = 0.05;
  constexpr double kSurely_m = 0.001;
  constexpr double kHardly_m = 0.05;
  constexpr std::size_t kEvery = 4;
  const Camera& camera = scene.camera();
  const double most = kMostOthers * static_cast<double>(part.points.size()) / kEvery;
  double all = 0;
  double others = 0;
  for (std::size_t i = 0; i < part.points.size(); i += kEvery) {
    const Eigen::Vector3d p = T_camera_node * part.points[i].point;
    const Eigen::Vector3d normal = T_camera_node.linear() * part.points[i].normal;
    if (!(p.z() > 0.05) || -normal.dot(p) < 0.2 * p.norm()) continue;
    ++all;
    const Eigen::Vector2d pixel = camera.project(p);
    const double z =
        camera.contains(pixel)
            ? static_cast<double>(drawn.depth(static_cast<int>(pixel.x() + 0.5), static_cast<int>(pixel.y() + 0.5)))
            : 0;
    const double off = std::abs(z - p.z());
    if (off < kSurely_m) continue;
    if (off > kHardly_m || off > scene.tolerance.at(p, normal)) ++others;
    if (others > most) return false;
  }
  return all > 0 && others <= kMostOthers * all;
}

}  // namespace

std::vector<Pose> starts_of(const MoveScene& scene, const Part& part, const WithoutPart& without) {
  const Pose old = scene.T_camera_node(part.node_position);
  std::vector<Pose> starts{old};
  for (const auto& piece : fitting_pieces(scene, part, without)) {
    starts.push_back(placed(part, old.linear(), piece));
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 1; k < kTurns; ++k) {
        const double angle = 2 * std::numbers::pi * k / kTurns;
        starts.push_back(placed(part, old.linear() * turn(part, axis, angle), piece));
      }
    }
  }
  return starts;
}

double way_m(const Part& part, const Pose& from, const Pose& to) {
  const double angle = Eigen::AngleAxisd{from.linear().transpose() * to.linear()}.angle();
  return (from * part.center - to * part.center).norm() + part.radius_m * angle;
}

std::vector<Pose> look_alikes(const MoveScene& scene, const Part& part, const Pose& T_camera_node) {
  constexpr double kSamePose_m = 0.02;
  DepthBuffer drawn{projected_window(part.submesh.bounds(), T_camera_node, scene.camera(), 1)};
  draw(part.submesh, part.counted, T_camera_node, scene.camera(), drawn);
  Pose unturned = scene.T_camera_node(part.node_position);
  unturned.translation() += T_camera_node * part.center - unturned * part.center;
  std::vector<Pose> tried = turned_as_a_cube(part, T_camera_node);
  tried.push_back(unturned);
  std::vector<Pose> alike{T_camera_node};
  for (const auto& other : tried) {
    const bool is_known = std::any_of(alike.begin(), alike.end(),
                                      [&](const Pose& pose) { return way_m(part, pose, other) < kSamePose_m; });
    if (!is_known && shows_the_same(scene, part, drawn, other)) alike.push_back(other);
  }
  return alike;
}

}  // namespace meshloop::adjust
