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

/// T_color_world at colour images that follow one another. Depth is measured between or beside the last two.
struct ColorPoses {
  /// The one before `before`; lost when there was none.
  TrackedPose earlier;
  TrackedPose before;
  TrackedPose after;
};

/// T_depth_world at the depth image's time (common/geometry/README.md, "From a depth pixel"): on the curve of constant
/// acceleration through the colour poses, or of constant velocity where `earlier` cannot help. The covariance, in the
/// depth camera's frame, knows those of the poses and of the calibration, and how much the motion may have changed in
/// between (README.md, "Between two colour images"). Lost when `before` and `after` both are, when the time lies
/// farther outside of both than half of what is between them, and when only one of them is known and farther away than
/// that or 20 ms, whichever is more.
[[nodiscard]] TrackedPose depth_pose_at(const Rig& rig, const ColorPoses& color, double depth_timestamp_s);

}  // namespace meshloop
