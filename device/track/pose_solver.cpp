#include "device/track/pose_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace meshloop {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kNearest_m = 1e-3;
constexpr double kConverged = 1e-8;
/// Of the information, each direction over its own scale.
constexpr double kLeastEigenvalue = 1e-7;

struct System {
  Matrix6 information = Matrix6::Zero();
  Twist gradient = Twist::Zero();
  int points = 0;
  int edges = 0;
};

bool in_front(const Eigen::Vector3d& p_world, const Pose& pose) {
  return (pose * p_world).z() > kNearest_m;
}

double tukey(double error_px, double gate_px) {
  const double share = error_px / gate_px;
  return share < 1 ? (1 - share * share) * (1 - share * share) : 0;
}

void add_point(System& system, const PointObservation& point, const Camera& camera, const Pose& pose, double gate_px) {
  if (!in_front(point.p_world, pose)) return;
  const ReprojectionTerm term = reprojection(point, camera, pose);
  const double weight = tukey(term.residual.norm(), gate_px);
  if (!(weight > 0)) return;
  const double information = weight / (point.sigma_px * point.sigma_px);
  system.information += information * term.jacobian.transpose() * term.jacobian;
  system.gradient += information * term.jacobian.transpose() * term.residual;
  ++system.points;
}

void add_edge(System& system, const EdgeObservation& edge, const Camera& camera, const Pose& pose, double gate_px) {
  if (!in_front(edge.p_world, pose)) return;
  const ReprojectionTerm term = reprojection({edge.p_world, edge.pixel, edge.sigma_px}, camera, pose);
  const double error = edge.normal.dot(term.residual);
  const double weight = tukey(std::abs(error), gate_px);
  if (!(weight > 0)) return;
  const Twist slope = term.jacobian.transpose() * edge.normal;
  const double information = weight / (edge.sigma_px * edge.sigma_px);
  system.information += information * slope * slope.transpose();
  system.gradient += information * error * slope;
  ++system.edges;
}

/// The inverse, or nothing when a direction is open. Metres and radians are made comparable by the diagonal.
std::optional<Matrix6> invert(const Matrix6& information) {
  const Twist diagonal = information.diagonal();
  if (!information.allFinite() || !(diagonal.minCoeff() > 0)) return std::nullopt;
  const Twist scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6 balanced = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver{balanced};
  if (solver.info() != Eigen::Success || solver.eigenvalues()(0) < kLeastEigenvalue) return std::nullopt;
  const Matrix6 inverse =
      solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose();
  return Matrix6{scale.asDiagonal() * inverse * scale.asDiagonal()};
}

}  // namespace

double edge_error_px(const EdgeObservation& edge, const Camera& camera, const Pose& T_camera_world) {
  const Eigen::Vector3d p_camera = T_camera_world * edge.p_world;
  if (!(p_camera.z() > kNearest_m)) return std::numeric_limits<double>::infinity();
  return edge.normal.dot(camera.project(p_camera) - edge.pixel);
}

std::optional<JointPose> solve_pose(const std::vector<PointObservation>& points,
                                    const std::vector<EdgeObservation>& edges, const Camera& camera, const Pose& start,
                                    const JointOptions& options) {
  JointPose result;
  result.T_camera_world = start;
  for (int i = 0; i < options.iterations; ++i) {
    System system;
    for (const auto& point : points) add_point(system, point, camera, result.T_camera_world, options.max_error_px);
    for (const auto& edge : edges) add_edge(system, edge, camera, result.T_camera_world, options.max_error_px);
    const auto covariance = invert(system.information);
    if (!covariance) return std::nullopt;
    const Twist step = -*covariance * system.gradient;
    if (!step.allFinite() || step.tail<3>().norm() > 0.5) return std::nullopt;
    result.T_camera_world = exp(step) * result.T_camera_world;
    result.covariance = *covariance;
    result.points = system.points;
    result.edges = system.edges;
    if (step.norm() < kConverged) break;
  }
  // Many small steps leave the rotation slightly out of shape.
  result.T_camera_world.linear() = Eigen::Quaterniond{result.T_camera_world.linear()}.normalized().toRotationMatrix();
  return result;
}

}  // namespace meshloop
