#pragma once
// Camera models. Pixel (u, v) has its centre at integer coordinates. Camera frame: x right, y down, z forward.
#include <Eigen/Core>
#include <array>

#include "common/base/result.h"

namespace meshloop {

/// A pinhole camera with the lens distortion of OpenCV: radial and tangential (Brown, Conrady), and rational where the
/// last three coefficients are not 0.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0;
  double fy = 0;
  double cx = 0;
  double cy = 0;
  /// k1, k2, p1, p2, k3, k4, k5, k6.
  std::array<double, 8> distortion{};

  [[nodiscard]] bool has_distortion() const;

  /// Pinhole projection of a point in the camera frame; lens distortion is left out. z must not be 0.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const {
    return {fx * p_camera.x() / p_camera.z() + cx, fy * p_camera.y() / p_camera.z() + cy};
  }
  /// The point at depth z (metres along the optical axis) behind an undistorted pixel.
  [[nodiscard]] Eigen::Vector3d back_project(double u, double v, double z) const {
    return {(u - cx) / fx * z, (v - cy) / fy * z, z};
  }
  /// Where the lens moves an undistorted pixel to. Means nothing beyond lens_limit().
  [[nodiscard]] Eigen::Vector2d distort(const Eigen::Vector2d& pixel) const;
  /// Distance from the axis, at z = 1, from which on the formula of the lens no longer moves points outwards: it turns
  /// back into the picture, where coefficients were fitted to its middle only. Looked for up to the farthest corner of
  /// the undistorted picture; infinite when there is none.
  [[nodiscard]] double lens_limit() const;
  /// Inside the picture, with `margin` pixels to each side.
  [[nodiscard]] bool contains(const Eigen::Vector2d& pixel, double margin = 0) const {
    return pixel.x() >= margin - 0.5 && pixel.y() >= margin - 0.5 && pixel.x() < width - 0.5 - margin &&
           pixel.y() < height - 0.5 - margin;
  }
  /// The same camera with a perfect lens.
  [[nodiscard]] Camera without_distortion() const;
};

/// Says what is wrong with a camera's numbers: sizes from 16 to 8192 pixels, focal lengths positive, all finite, and a
/// lens that does not fold the picture over before its nearest edge.
[[nodiscard]] Status validate(const Camera& camera);

}  // namespace meshloop
