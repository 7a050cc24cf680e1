#pragma once
// Which part of a picture a thing in the world can touch: what lies outside need not be drawn.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace meshloop {

/// Columns x to x + width - 1, rows y to y + height - 1.
struct ScreenArea {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
  friend bool operator==(const ScreenArea&, const ScreenArea&) = default;
};

/// The pixels between the outermost projections of the corners, and a margin; within the picture. A hull that reaches
/// behind the camera (nearer than near_m) may be anywhere: the whole picture. Empty without corners.
[[nodiscard]] ScreenArea area_of_hull(const std::vector<Eigen::Vector3d>& corners_world, const Camera& camera,
                                      const Pose& T_camera_world, double near_m);

/// The smallest area with both in it.
[[nodiscard]] ScreenArea joined(const ScreenArea& a, const ScreenArea& b);

/// Adds the box's eight corners.
void append_corners(std::vector<Eigen::Vector3d>& corners_world, const Eigen::AlignedBox3f& box,
                    const Pose& T_world_box);

}  // namespace meshloop
