#pragma once
// The pose of the capture rig, without the model: markers, and between them features whose depth the rig measures.
#include <memory>
#include <optional>

#include "common/base/result.h"
#include "common/geometry/rig.h"
#include "common/geometry/tracked_pose.h"
#include "common/image/frames.h"
#include "common/recording/marker_file.h"

namespace meshloop {

struct RigTrackerOptions {
  /// May be empty when there is a first pose.
  std::optional<MarkerMap> markers;
  /// T_color_world of the first frame, for recordings without a marker.
  std::optional<Pose> first_pose;
};

class RigTracker {
 public:
  /// Refuses options with neither markers nor a first pose.
  [[nodiscard]] static Result<std::unique_ptr<RigTracker>> create(const Rig& rig, const RigTrackerOptions& options);
  virtual ~RigTracker() = default;
  /// T_color_world at the frame's colour time. Frames must come in order of time.
  virtual TrackedPose track(const RgbdFrame& frame) = 0;
};

/// T_depth_world at the depth image's time from the colour poses before and after it (common/geometry/README.md, "From
/// a depth pixel", with interpolation on SE(3)). Covariance is carried over to the depth camera's frame. Lost when both
/// are lost.
[[nodiscard]] TrackedPose depth_pose_at(const Rig& rig, const TrackedPose& color_before, const TrackedPose& color_after,
                                        double depth_timestamp_s);

}  // namespace meshloop
