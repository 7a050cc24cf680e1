#pragma once
// The depth of several frames, in the pixels of one.
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/change/region.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop {

/// One frame's measured depth, in metres, and where it was measured from.
struct DepthView {
  const DepthImage* depth = nullptr;
  Pose T_camera_world = Pose::Identity();
  /// As in TrackedPose; a fusion takes the pose as it is.
  PoseCovariance covariance = PoseCovariance::Zero();
};

struct FusedDepth {
  /// Metres; 0 where the first view measured nothing, or more views see through its surface than measure it.
  DepthImage depth;
  /// Of how many measurements; 0 where there is no depth.
  Image<std::uint8_t> measurements;
  /// Views that had a say, the first one included.
  std::size_t views = 0;
};

/// As many views as are looked at.
inline constexpr std::size_t kMostFusedViews = 16;

/// Fuses the depth of up to kMostFusedViews views of one camera in the first one's pixels. The surface that the first
/// view measured is looked up in each other view; of what lies there within 3 sigma of the median the most likely depth
/// is taken, the mean with weights of one divided by each view's variance at its own range, so that nothing is averaged
/// across two surfaces. Views that look at a surface from more than 25 degrees aside have no say
/// there, nor have those in which something stands before it. A view that does not measure more of the new surface
/// (`mask` 2) than it sees through, made before that came or looking elsewhere, has no say at all. Pixels of `mask`
/// that are 0 keep what the first view measured; an empty mask is one of ones. There must be a view; each depth image,
/// and the mask, has the camera's size.
[[nodiscard]] FusedDepth fuse_depth(std::span<const DepthView> views, const Camera& camera, const SensorModel& sensor,
                                    const Image<std::uint8_t>& mask);

/// Pixels of the windows around the regions that may become new surface, in an image of the ids' size: what a fusion
/// for them has to look at.
[[nodiscard]] Image<std::uint8_t> fused_pixels(const RegionMap& regions);

}  // namespace meshloop
