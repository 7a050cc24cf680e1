#include "common/features/robust_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/median.h"

namespace meshloop {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// 95 % efficiency for normal residuals (Huber, Ronchetti 2009, section 4.8).
constexpr double kTukey = 4.685;
// Median length of a residual of two standard normal components (Rayleigh).
constexpr double kMedianLength = 1.1774;
// Tukey's weights lower the information of good points and the estimate is a little less efficient: the covariance is
// E[w] E[psi^2] / E[psi']^2 = 0.898 times the inverse of the weighted information, for two normal components.
constexpr double kInformation = 0.898;
// And the weighted sum of squares of n good points is E[w e^2] / 2 = 0.685 times what it is without weights.
constexpr double kWeightedSquares = 0.685;
constexpr double kNearestDepth = 1e-3;
constexpr double kConverged = 1e-9;

struct Errors {
  // Reprojection error of each point in pixels; infinite behind the camera.
  std::vector<double> pixels;
  // The same over the point's own standard deviation.
  std::vector<double> normalised;
};

Errors errors_of(const std::vector<PointObservation>& points, const Camera& camera, const Pose& pose) {
  Errors errors;
  errors.pixels.reserve(points.size());
  errors.normalised.reserve(points.size());
  for (const PointObservation& point : points) {
    const Eigen::Vector3d p = pose * point.p_world;
    double error = std::numeric_limits<double>::infinity();
    if (p.z() > kNearestDepth) error = (camera.project(p) - point.pixel).norm();
    if (!std::isfinite(error)) error = std::numeric_limits<double>::infinity();
    errors.pixels.push_back(error);
    errors.normalised.push_back(error / point.sigma_px);
  }
  return errors;
}

// How much larger than stated the noise is, from the median length of the residuals below the gate; at least 1.
double noise_scale(const Errors& errors, double gate_px) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i < errors.pixels.size(); ++i) {
    if (errors.pixels[i] <= gate_px && std::isfinite(errors.pixels[i])) lengths.push_back(errors.normalised[i]);
  }
  if (lengths.empty()) return 1;
  return std::max(1.0, median(std::move(lengths)) / kMedianLength);
}

struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();
  Twist gradient = Twist::Zero();
  // Sum of weighted squared residuals, each over its standard deviation.
  double squares = 0;
  int used = 0;
};

NormalEquations accumulate(const std::vector<PointObservation>& points, const Camera& camera, const Pose& pose,
                           const Errors& errors, double scale, double gate_px) {
  NormalEquations sum;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double share = errors.normalised[i] / (kTukey * scale);
    if (!(share < 1) || errors.pixels[i] > gate_px) continue;
    const double weight = (1 - share * share) * (1 - share * share);
    const ReprojectionTerm term = reprojection(points[i], camera, pose);
    const double information = weight / (points[i].sigma_px * points[i].sigma_px);
    sum.information += information * term.jacobian.transpose() * term.jacobian;
    sum.gradient += information * term.jacobian.transpose() * term.residual;
    sum.squares += weight * errors.normalised[i] * errors.normalised[i];
    ++sum.used;
  }
  return sum;
}

// The inverse, or nothing when some direction of the pose is not fixed by the points. Metres and radians are made
// comparable by the diagonal first.
std::optional<Matrix6d> invert_guarded(const Matrix6d& information, double depth_m) {
  const Twist diagonal = information.diagonal();
  if (!information.allFinite() || diagonal.minCoeff() <= 0) return std::nullopt;
  const Twist scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6d balanced = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver{balanced};
  constexpr double kSmallestEigenvalue = 1e-9;
  if (solver.info() != Eigen::Success || solver.eigenvalues()(0) < kSmallestEigenvalue) return std::nullopt;
  const Matrix6d inverse = scale.asDiagonal() * solver.eigenvectors() *
                           solver.eigenvalues().cwiseInverse().asDiagonal() * solver.eigenvectors().transpose() *
                           scale.asDiagonal();
  // Beyond this the linearisation, and with it the covariance, means nothing.
  constexpr double kLargestAngle = 0.5;
  const double largest_shift_m = 0.5 * depth_m;
  const bool rotation_fixed = inverse.diagonal().tail<3>().maxCoeff() < kLargestAngle * kLargestAngle;
  const bool translation_fixed = inverse.diagonal().head<3>().maxCoeff() < largest_shift_m * largest_shift_m;
  if (!rotation_fixed || !translation_fixed) return std::nullopt;
  return inverse;
}

double median_depth(const std::vector<PointObservation>& points, const Pose& pose) {
  std::vector<double> depths;
  depths.reserve(points.size());
  for (const PointObservation& point : points) depths.push_back(std::abs((pose * point.p_world).z()));
  return median(std::move(depths));
}

// Gauss-Newton from `pose` to the minimum with points up to gate_px; false when a step cannot be computed.
bool descend(const std::vector<PointObservation>& points, const Camera& camera, double gate_px, int iterations,
             Pose& pose) {
  for (int i = 0; i < iterations; ++i) {
    const Errors errors = errors_of(points, camera, pose);
    const NormalEquations sum = accumulate(points, camera, pose, errors, noise_scale(errors, gate_px), gate_px);
    if (sum.used < 3) return false;
    // A trace of damping keeps a step along a free direction finite; the guard afterwards finds that direction.
    Matrix6d damped = sum.information;
    damped.diagonal() *= 1 + 1e-9;
    Twist step = -damped.ldlt().solve(sum.gradient);
    if (!step.allFinite()) return false;
    const double longest = step.tail<3>().norm();
    constexpr double kLongestTurn = 0.3;
    if (longest > kLongestTurn) step *= kLongestTurn / longest;
    pose = exp(step) * pose;
    if (step.norm() < kConverged) break;
  }
  pose.linear() = Eigen::Quaterniond{pose.linear()}.normalized().toRotationMatrix();
  return pose.matrix().allFinite();
}

bool usable(const std::vector<PointObservation>& points, const RobustPoseOptions& options) {
  if (static_cast<int>(points.size()) < std::max(options.min_inliers, 3)) return false;
  return std::all_of(points.begin(), points.end(), [](const PointObservation& point) {
    return point.p_world.allFinite() && point.pixel.allFinite() && point.sigma_px > 0 && std::isfinite(point.sigma_px);
  });
}

}  // namespace

ReprojectionTerm reprojection(const PointObservation& point, const Camera& camera, const Pose& T_camera_world) {
  const Eigen::Vector3d p = T_camera_world * point.p_world;
  const double inverse_z = 1 / p.z();
  Eigen::Matrix<double, 2, 3> projection;
  projection << camera.fx * inverse_z, 0, -camera.fx * p.x() * inverse_z * inverse_z,  //
      0, camera.fy * inverse_z, -camera.fy * p.y() * inverse_z * inverse_z;
  ReprojectionTerm term;
  term.residual = camera.project(p) - point.pixel;
  term.jacobian.leftCols<3>() = projection;
  term.jacobian.rightCols<3>() = -projection * skew(p);
  return term;
}

std::optional<RobustPose> refine_pose(const std::vector<PointObservation>& points, const Camera& camera,
                                      const Pose& start, const RobustPoseOptions& options) {
  if (!usable(points, options) || !start.matrix().allFinite()) return std::nullopt;
  RobustPose result;
  result.T_camera_world = start;
  // Without a gate first, since a start that is off lifts all errors; then with it.
  const double no_gate = std::numeric_limits<double>::infinity();
  if (!descend(points, camera, no_gate, options.iterations, result.T_camera_world)) return std::nullopt;
  if (!descend(points, camera, options.max_error_px, options.iterations, result.T_camera_world)) return std::nullopt;

  const Errors errors = errors_of(points, camera, result.T_camera_world);
  const double scale = noise_scale(errors, options.max_error_px);
  const NormalEquations sum = accumulate(points, camera, result.T_camera_world, errors, scale, options.max_error_px);
  double squares_px = 0;
  for (const double error : errors.pixels) {
    result.inlier.push_back(error <= options.max_error_px);
    if (!result.inlier.back()) continue;
    ++result.inliers;
    squares_px += error * error;
  }
  if (result.inliers < options.min_inliers) return std::nullopt;
  const auto covariance = invert_guarded(sum.information, median_depth(points, result.T_camera_world));
  if (!covariance) return std::nullopt;
  result.rms_px = std::sqrt(squares_px / result.inliers);
  const double freedom = std::max(1.0, 2.0 * sum.used - 6);
  const double variance = std::max(1.0, sum.squares / kWeightedSquares / freedom);
  result.covariance = kInformation * variance * *covariance;
  return result;
}

}  // namespace meshloop
