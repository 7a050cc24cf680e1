#pragma once
#include <memory>

#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace meshloop {

struct RegionOptions {
  /// Smaller regions are noise. In pixels at 640x480; scaled with the image's area.
  int min_pixels = 60;
  /// And this large in the world.
  double min_area_m2 = 1e-4;
  /// Seen in this many frames before it is offered.
  int confirm_frames = 3;
};

/// Groups changed pixels into regions and follows them from frame to frame (ids are stable, by overlap in the world).
class RegionTracker {
 public:
  explicit RegionTracker(const RegionOptions& options) : options_{options} {}
  /// Frames in the order of time. T_camera_world and camera are the depth camera's.
  RegionMap update(const Comparison& comparison, const DepthImage& measured, const Camera& camera,
                   const Pose& T_camera_world);
  /// Forgets all (after the model changed, the regions are other ones).
  void reset();

 private:
  RegionOptions options_;
  std::vector<Region> known_;
  RegionId next_id_ = 1;
};

}  // namespace meshloop
