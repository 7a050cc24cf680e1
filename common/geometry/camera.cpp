#include "common/geometry/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace meshloop {

bool Camera::has_distortion() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& pixel) const {
  // Brown-Conrady as in OpenCV's calib3d documentation.
  const auto [k1, k2, p1, p2, k3] = distortion;
  const double x = (pixel.x() - cx) / fx;
  const double y = (pixel.y() - cy) / fy;
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {fx * xd + cx, fy * yd + cy};
}

Camera Camera::without_distortion() const {
  Camera camera = *this;
  camera.distortion = {};
  return camera;
}

Status validate(const Camera& camera) {
  constexpr int kSmallest = 16;
  constexpr int kLargest = 8192;
  if (std::min(camera.width, camera.height) < kSmallest || std::max(camera.width, camera.height) > kLargest) {
    return fail(fmt::format("the image size {}x{} is outside {} to {} pixels", camera.width, camera.height, kSmallest,
                            kLargest));
  }
  const bool finite =
      std::isfinite(camera.fx) && std::isfinite(camera.fy) && std::isfinite(camera.cx) && std::isfinite(camera.cy) &&
      std::all_of(camera.distortion.begin(), camera.distortion.end(), [](double k) { return std::isfinite(k); });
  if (!finite) return fail("an intrinsic parameter is not a finite number");
  if (camera.fx <= 0 || camera.fy <= 0) return fail("fx and fy must be positive");
  return {};
}

}  // namespace meshloop
