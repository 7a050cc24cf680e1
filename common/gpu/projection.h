#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/geometry/camera.h"
#include "common/gpu/screen_area.h"

namespace meshloop {

/// From the camera's frame (x right, y down, z forward) to GL clip space. The centre of pixel (u, v) becomes the centre
/// of texel (u, v): normalised y grows with the row, so that row 0 of a texture is row 0 of the image. The clip
/// coordinate w is the depth z in metres.
[[nodiscard]] Eigen::Matrix4d clip_from_camera(const Camera& camera, double near_m, double far_m);

/// From the clip space of the whole picture to that of a part of it, for leaving out what lies beside the part.
[[nodiscard]] Eigen::Matrix4d clip_of_part(const ScreenArea& part, const Camera& camera);

/// True when the box, in the frame on the right of the matrix, lies outside one face of the view for certain.
[[nodiscard]] bool is_outside_view(const Eigen::Matrix4d& clip_from_frame, const Eigen::AlignedBox3f& bounds);

}  // namespace meshloop
