#pragma once
// The handheld's pose from its colour camera and the shared model.
#include <memory>

#include "common/base/result.h"
#include "common/geometry/camera.h"
#include "common/geometry/tracked_pose.h"
#include "common/gpu/context.h"
#include "common/image/frames.h"
#include "common/mesh/model.h"

namespace meshloop {

struct ModelTrackerOptions {
  int max_features = 300;
  int min_inliers = 15;
};

/// KLT features take their world coordinates from the model's rendered depth at the pose of the frame they were found
/// in; the pose follows from them, and is then held to the model itself, so that errors do not add up: corners of its
/// colours and edges of its shape, rendered at that pose, are found in the camera image. One thread, that of the
/// context.
class ModelTracker {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ModelTracker>> create(GpuContext& context, const Camera& camera,
                                                                    const ModelTrackerOptions& options);
  virtual ~ModelTracker() = default;
  /// Draws the model once and forgets it: the first use of a shader compiles it, which must not delay a frame.
  virtual void warm_up(const Model& model) = 0;
  /// Starts (again) from a known pose: T_camera_world of the next frame.
  virtual void start_at(const Pose& T_camera_world) = 0;
  /// Frames in the order of time, undistorted, in the camera's size. The model may be another one at each call.
  virtual TrackedPose track(const ColorFrame& frame, const std::shared_ptr<const Model>& model) = 0;
};

}  // namespace meshloop
