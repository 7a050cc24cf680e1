#include "common/gpu/screen_area.h"

#include <algorithm>
#include <cmath>

namespace meshloop {
namespace {

/// Antialiasing, and the 3 x 3 pixels that soften an outline.
constexpr double kMargin_px = 2;

}  // namespace

ScreenArea area_of_hull(const std::vector<Eigen::Vector3d>& corners_world, const Camera& camera,
                        const Pose& T_camera_world, double near_m) {
  if (corners_world.empty()) return {};
  Eigen::AlignedBox2d outermost;
  for (const auto& corner : corners_world) {
    const Eigen::Vector3d p_camera = T_camera_world * corner;
    if (p_camera.z() < near_m) return {0, 0, camera.width, camera.height};
    outermost.extend(camera.project(p_camera));
  }
  const Eigen::Vector2d last_pixel{camera.width - 1, camera.height - 1};
  // Clamped before it becomes a number of pixels: a corner near the camera's plane projects very far away.
  const Eigen::Vector2d low =
      (outermost.min().array() - kMargin_px).floor().max(0.0).min(last_pixel.array() + 1).matrix();
  const Eigen::Vector2d high = (outermost.max().array() + kMargin_px).ceil().min(last_pixel.array()).max(-1.0).matrix();
  const ScreenArea area{static_cast<int>(low.x()), static_cast<int>(low.y()), static_cast<int>(high.x() - low.x()) + 1,
                        static_cast<int>(high.y() - low.y()) + 1};
  return area.empty() ? ScreenArea{} : area;
}

ScreenArea joined(const ScreenArea& a, const ScreenArea& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  const int x = std::min(a.x, b.x);
  const int y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

void append_corners(std::vector<Eigen::Vector3d>& corners_world, const Eigen::AlignedBox3f& box,
                    const Pose& T_world_box) {
  for (int i = 0; i < 8; ++i) {
    corners_world.push_back(T_world_box * box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)).cast<double>());
  }
}

}  // namespace meshloop
