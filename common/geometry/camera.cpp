#include "common/geometry/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace meshloop {
namespace {

// By how much the lens moves a point away from the axis, r2 being its squared distance at z = 1.
double radial_factor(const std::array<double, 8>& distortion, double r2) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = distortion;
  return (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
}

double corner_radius(const Camera& camera) {
  const double x = std::max(camera.cx + 0.5, camera.width - 0.5 - camera.cx) / camera.fx;
  const double y = std::max(camera.cy + 0.5, camera.height - 0.5 - camera.cy) / camera.fy;
  return std::hypot(x, y);
}

constexpr const char* kOrder = "the order is k1, k2, p1, p2, k3 and, for a rational lens, k4, k5, k6";

// The picture's middle, up to its nearest edge, must be seen, and by something that can be a lens.
Status check_lens(const Camera& camera) {
  constexpr double kLargestFactor = 5;
  const double limit = camera.lens_limit();
  const double farthest = std::min(limit, corner_radius(camera));
  const double factor = radial_factor(camera.distortion, farthest * farthest);
  if (factor > kLargestFactor) {
    return fail(fmt::format("the distortion moves points {:.3g} times as far from the centre; {}", factor, kOrder));
  }
  if (std::isinf(limit)) return {};
  const double edge_px =
      std::min({camera.cx + 0.5, camera.width - 0.5 - camera.cx, camera.cy + 0.5, camera.height - 0.5 - camera.cy});
  const double seen_px = limit * factor * std::min(camera.fx, camera.fy);
  if (seen_px >= edge_px) return {};
  return fail(fmt::format("the distortion folds the picture over {:.0f} pixels from its centre; {}",
                          std::max(0.0, seen_px), kOrder));
}

}  // namespace

bool Camera::has_distortion() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& pixel) const {
  // OpenCV's calib3d documentation, "Detailed description", without thin prism and tilt.
  const double p1 = distortion[2];
  const double p2 = distortion[3];
  const double x = (pixel.x() - cx) / fx;
  const double y = (pixel.y() - cy) / fy;
  const double r2 = x * x + y * y;
  const double radial = radial_factor(distortion, r2);
  const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return {fx * xd + cx, fy * yd + cy};
}

double Camera::lens_limit() const {
  constexpr int kSteps = 512;
  if (!has_distortion()) return std::numeric_limits<double>::infinity();
  const double farthest = corner_radius(*this);
  double before = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = farthest * i / kSteps;
    const double moved = r * radial_factor(distortion, r * r);
    if (!(moved > before) || !std::isfinite(moved)) return farthest * (i - 1) / kSteps;
    before = moved;
  }
  return std::numeric_limits<double>::infinity();
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
  return check_lens(camera);
}

}  // namespace meshloop
