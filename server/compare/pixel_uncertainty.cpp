#include "server/compare/pixel_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/change/classify_rule.h"
#include "server/compare/compare_input.h"

namespace meshloop {
namespace {

double depth_or_nothing(const DepthImage& depth, int u, int v) {
  const bool inside = u >= 0 && v >= 0 && u < depth.width() && v < depth.height();
  return inside ? static_cast<double>(depth(u, v)) : 0.0;
}

// Of inverse depth, from one pixel to the next.
double flatter_slope(double before_m, double here_m, double after_m) {
  const double backward = before_m > 0 ? 1 / here_m - 1 / before_m : 0;
  const double forward = after_m > 0 ? 1 / after_m - 1 / here_m : 0;
  if (before_m <= 0) return forward;
  if (after_m <= 0) return backward;
  return std::abs(forward) < std::abs(backward) ? forward : backward;
}

template <class Jacobian, class Covariance>
double largest_variance(const Jacobian& J, const Covariance& covariance) {
  return std::max(0.0, (J * covariance * J.transpose()).diagonal().maxCoeff());
}

}  // namespace

Eigen::Vector3d expected_plane(const DepthImage& expected, const Camera& camera, int u, int v) {
  const auto at = [&](int x, int y) { return depth_or_nothing(expected, x, y); };
  const double z = at(u, v);
  const Eigen::Vector3d ray = camera.back_project(u, v, 1);
  const double x = camera.fx * flatter_slope(at(u - 1, v), z, at(u + 1, v));
  const double y = camera.fy * flatter_slope(at(u, v - 1), z, at(u, v + 1));
  return {x, y, 1 / z - ray.x() * x - ray.y() * y};
}

Eigen::Matrix<double, 1, 6> depth_by_twist(const Eigen::Vector3d& plane, const Eigen::Vector3d& p_camera) {
  Eigen::Matrix<double, 1, 6> J;
  J << plane.transpose(), p_camera.cross(plane).transpose();
  return p_camera.z() * J;
}

Eigen::RowVector4d depth_by_intrinsics(const Camera& camera, const Eigen::Vector3d& plane,
                                       const Eigen::Vector3d& p_camera) {
  const double z = p_camera.z();
  const double by_cx = z * z * plane.x() / camera.fx;
  const double by_cy = z * z * plane.y() / camera.fy;
  return {by_cx * p_camera.x() / z, by_cy * p_camera.y() / z, by_cx, by_cy};
}

Eigen::Matrix<double, 2, 4> pixel_by_intrinsics(const Eigen::Vector3d& p_camera) {
  Eigen::Matrix<double, 2, 4> J;
  J << p_camera.x() / p_camera.z(), 0, 1, 0, 0, p_camera.y() / p_camera.z(), 0, 1;
  return J;
}

Eigen::Matrix<double, 2, 6> pixel_by_twist(const Camera& camera, const Eigen::Vector3d& p_camera) {
  const Eigen::Vector3d ray = p_camera / p_camera.z();
  const Eigen::Vector3d a_u = camera.fx / p_camera.z() * Eigen::Vector3d{1, 0, -ray.x()};
  const Eigen::Vector3d a_v = camera.fy / p_camera.z() * Eigen::Vector3d{0, 1, -ray.y()};
  Eigen::Matrix<double, 2, 6> J;
  J.row(0) << a_u.transpose(), p_camera.cross(a_u).transpose();
  J.row(1) << a_v.transpose(), p_camera.cross(a_v).transpose();
  return J;
}

double viewing_angle(const Eigen::Vector3d& plane, const Eigen::Vector3d& p_camera) {
  // plane . p = 1 by definition.
  return std::acos(std::min(1.0, 1 / (plane.norm() * p_camera.norm())));
}

PixelUncertainty pixel_uncertainty(const CompareInput& input, const DepthImage& expected, int u, int v,
                                   double measured_m) {
  const double k = input.threshold.value;
  if (input.threshold.kind == Threshold::Kind::fixed) return {k, 0, {0, 0}};
  const Camera& camera = input.camera;
  const double expected_m = depth_or_nothing(expected, u, v);
  const bool is_modelled = expected_m > 0;
  const Eigen::Vector3d p = camera.back_project(u, v, is_modelled ? expected_m : measured_m);
  // Where no surface is expected, one that faces the camera stands in.
  const Eigen::Vector3d plane = is_modelled ? expected_plane(expected, camera, u, v) : p / p.squaredNorm();
  const double theta = viewing_angle(plane, p);
  if (theta > kSteepestSeen_deg * std::numbers::pi / 180) return {rule::kNoThreshold_m, 0, {0, 0}};

  const int frames = input.frames_averaged == nullptr ? 1 : (*input.frames_averaged)(u, v);
  const Eigen::Vector2d slope =
      is_modelled ? Eigen::Vector2d{plane.x() / camera.fx, plane.y() / camera.fy} : Eigen::Vector2d::Zero();
  const double lateral_px = input.sensor.sigma_lateral_px(theta);
  // Depth changes by -z^2 times the change of inverse depth.
  const double lateral_m = lateral_px * expected_m * expected_m * slope.norm();
  const double variance = input.sensor.variance_m2(std::max(expected_m, measured_m), theta, frames) +
                          lateral_m * lateral_m + largest_variance(depth_by_twist(plane, p), input.pose.covariance) +
                          largest_variance(depth_by_intrinsics(camera, plane, p), input.intrinsics_covariance) +
                          input.model_sigma_m * input.model_sigma_m + kLatticeSigma_m * kLatticeSigma_m;
  const double threshold_m = k * std::sqrt(variance);
  if (threshold_m > kLargestThreshold_m) return {rule::kNoThreshold_m, 0, {0, 0}};

  const double footprint_px = std::max(lateral_px, kFootprintSigma_px);
  const double variance_px2 = footprint_px * footprint_px +
                              largest_variance(pixel_by_twist(camera, p), input.pose.covariance) +
                              largest_variance(pixel_by_intrinsics(p), input.intrinsics_covariance);
  const double reach = std::floor(k * std::sqrt(variance_px2) + 0.5);
  return {threshold_m, static_cast<int>(std::min<double>(reach, kLargestReach_px)), slope};
}

}  // namespace meshloop
