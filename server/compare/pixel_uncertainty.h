#pragma once
// How large a difference at one pixel must be to count. In double; the shader has the same formulas in float.
#include <Eigen/Core>

#include "server/compare/comparator.h"

namespace meshloop {

/// N of the plane N . p = 1 through the expected surface at a pixel, in the camera's frame, in 1/m: the surface's
/// normal divided by the plane's distance from the camera. From differences of inverse depth, which is linear in the
/// pixel for a plane; of the two sides the flatter one, so that a depth edge is not taken for a slope.
[[nodiscard]] Eigen::Vector3d expected_plane(const DepthImage& expected, const Camera& camera, int u, int v);

/// Derivative of the expected depth behind a fixed pixel by the twist (v, w) of T_estimated = exp(twist) * T_true:
/// z [N, p x N], with p = z ray.
[[nodiscard]] Eigen::Matrix<double, 1, 6> depth_by_twist(const Eigen::Vector3d& plane, const Eigen::Vector3d& p_camera);

/// Derivative of the expected depth behind a fixed pixel by the camera's (fx, fy, cx, cy). The ray through the pixel
/// turns: dz/dray = -z^2 N, dray_x/dfx = -ray_x / fx, dray_x/dcx = -1 / fx.
[[nodiscard]] Eigen::RowVector4d depth_by_intrinsics(const Camera& camera, const Eigen::Vector3d& plane,
                                                     const Eigen::Vector3d& p_camera);

/// Derivative of a point's pixel by (fx, fy, cx, cy).
[[nodiscard]] Eigen::Matrix<double, 2, 4> pixel_by_intrinsics(const Eigen::Vector3d& p_camera);

/// Derivative of a point's pixel by the same twist.
[[nodiscard]] Eigen::Matrix<double, 2, 6> pixel_by_twist(const Camera& camera, const Eigen::Vector3d& p_camera);

/// Angle between the ray to a point and the plane's normal, 0 to pi/2.
[[nodiscard]] double viewing_angle(const Eigen::Vector3d& plane, const Eigen::Vector3d& p_camera);

struct PixelUncertainty {
  /// rule::kNoThreshold_m where nothing can be told.
  double threshold_m = 0;
  /// How far to each side a surface may lie that was measured here.
  int reach_px = 0;
  /// Change of the expected surface's inverse depth from one pixel to the next; 0 where none is expected.
  Eigen::Vector2d inverse_depth_slope = Eigen::Vector2d::Zero();
};

/// At pixel (u, v), where `measured_m` is above 0. `expected` is the image of expected depth.
[[nodiscard]] PixelUncertainty pixel_uncertainty(const CompareInput& input, const DepthImage& expected, int u, int v,
                                                 double measured_m);

}  // namespace meshloop
