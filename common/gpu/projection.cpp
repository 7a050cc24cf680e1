#include "common/gpu/projection.h"

#include <array>

namespace meshloop {

Eigen::Matrix4d clip_from_camera(const Camera& camera, double near_m, double far_m) {
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = 2 * camera.fx / camera.width;
  clip(0, 2) = (2 * camera.cx + 1) / camera.width - 1;
  clip(1, 1) = 2 * camera.fy / camera.height;
  clip(1, 2) = (2 * camera.cy + 1) / camera.height - 1;
  clip(2, 2) = (far_m + near_m) / (far_m - near_m);
  clip(2, 3) = -2 * far_m * near_m / (far_m - near_m);
  clip(3, 2) = 1;
  return clip;
}

Eigen::Matrix4d clip_of_part(const ScreenArea& part, const Camera& camera) {
  Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
  clip(0, 0) = static_cast<double>(camera.width) / part.width;
  clip(0, 3) = (camera.width - 2.0 * part.x) / part.width - 1;
  clip(1, 1) = static_cast<double>(camera.height) / part.height;
  clip(1, 3) = (camera.height - 2.0 * part.y) / part.height - 1;
  return clip;
}

bool is_outside_view(const Eigen::Matrix4d& clip_from_frame, const Eigen::AlignedBox3f& bounds) {
  if (bounds.isEmpty()) return true;
  std::array<int, 6> outside{};
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner = bounds.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
    const Eigen::Vector4d clip = clip_from_frame * corner.cast<double>().homogeneous();
    for (int axis = 0; axis < 3; ++axis) {
      outside[static_cast<std::size_t>(2 * axis)] += clip(axis) < -clip.w() ? 1 : 0;
      outside[static_cast<std::size_t>(2 * axis + 1)] += clip(axis) > clip.w() ? 1 : 0;
    }
  }
  for (const int corners : outside) {
    if (corners == 8) return true;
  }
  return false;
}

}  // namespace meshloop
