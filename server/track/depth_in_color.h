#pragma once
// The rig's depth measurements in the pixels of the colour camera. Pure functions, used inside this stage.
#include <optional>

#include "common/geometry/rig.h"
#include "common/image/image.h"

namespace meshloop {

/// One measurement: where it lies in the colour image, and its depth along the colour camera's axis (0: none).
struct MappedDepth {
  float u = 0;
  float v = 0;
  float z = 0;
};

struct DepthInColor {
  /// Size of the colour image; of several surfaces in one pixel the nearest.
  Image<MappedDepth> nearest;
  /// How many pixels a measurement covers to each side of its own, where the depth camera is the coarser one.
  int reach = 0;
};

/// T_color_depth includes how the rig moved between the two exposures. A depth image that has not the size of rig.depth
/// (rig.color when registered) gives no measurements. common/geometry/README.md, "From a depth pixel", without the
/// world between.
[[nodiscard]] DepthInColor depth_in_color(const Rig& rig, const DepthImage& depth, const Pose& T_color_depth);

/// The depth at a pixel of the one surface around it: inverse depth is linear in the image of a plane, so a plane
/// through the measurements around is exact also where it is seen at a grazing angle. Nothing where they do not lie on
/// one plane (an edge in depth, where a corner could belong to either side) or where less than half of them are there.
[[nodiscard]] std::optional<double> surface_depth_at(const DepthInColor& depth, const Eigen::Vector2d& pixel,
                                                     const SensorModel& sensor);

}  // namespace meshloop
