#pragma once
// Poses of a camera in closed form from the fewest points that fix them; starts for refine_pose. Used inside this room.
#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace meshloop {

/// The up to four T_camera_world that see three points at their undistorted pixels (Ke, Roumeliotis 2017).
[[nodiscard]] std::vector<Pose> poses_from_three(const std::array<Eigen::Vector3d, 3>& p_world,
                                                 const std::array<Eigen::Vector2d, 3>& pixels, const Camera& camera);

/// Both T_camera_square that fit a square (Collins, Bartoli 2014, "Infinitesimal plane-based pose estimation"). The
/// square's frame: origin in its middle, x right, y up, z out of its front. Pixels clockwise from the upper left.
[[nodiscard]] std::vector<Pose> poses_from_square(double side_m, const std::array<Eigen::Vector2d, 4>& pixels,
                                                  const Camera& camera);

}  // namespace meshloop
