#pragma once
// The rig's depth measurements in the pixels of the colour camera. Pure functions, used inside this stage.
#include <optional>

#include "common/geometry/rig.h"
#include "common/image/image.h"

namespace meshloop {

/// Depth along the colour camera's axis for each of its pixels, 0 where nothing falls; of several surfaces the nearest.
/// T_color_depth includes how the rig moved between the two exposures. The depth image has the size of rig.depth (or of
/// rig.color when registered); nothing but zeros otherwise. Equations 2 to 4 of the design, without the world between.
[[nodiscard]] DepthImage depth_in_color(const Rig& rig, const DepthImage& depth, const Pose& T_color_depth);

/// The depth of the one surface around a pixel: the median of 3x3 pixels. Nothing at an edge in depth, where a corner
/// could lie on either side, or where less than five of them were measured.
[[nodiscard]] std::optional<double> surface_depth_at(const DepthImage& depth, const Eigen::Vector2d& pixel);

}  // namespace meshloop
