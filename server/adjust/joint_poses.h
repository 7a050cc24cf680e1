#pragma once
// The poses of several frames of one state of the world, made better together.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/change/comparison.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop {

/// One of several frames: what it measured, where its tracker says that it stood, and how certain that is.
struct PosedDepth {
  const DepthImage* depth = nullptr;
  Pose T_camera_world = Pose::Identity();
  /// As in TrackedPose; a pose whose covariance cannot be inverted counts as exact, and stays.
  PoseCovariance covariance = PoseCovariance::Zero();
  /// With the model, from this very pose; null: its points are looked up in the nearest frame before it that has one.
  const Comparison* comparison = nullptr;
};

struct JointPoses {
  /// From the world to each frame's camera, in the frames' order; their own where it was refused.
  std::vector<Pose> T_camera_world;
  /// Root mean square distance of what agrees, in metres: from the model, and between frames.
  struct Distances {
    double model_m = 0;
    double frames_m = 0;
  };
  Distances before;
  Distances after;
  /// Flat pieces that agree with the model, and with another frame.
  int on_model = 0;
  int between_frames = 0;
  /// Directions of the first frame's pose that the model holds, of six; and of the others' relative to the first one
  /// that what both measured holds, the least of all. The poses keep what the tracker said in the rest.
  int held_by_model = 0;
  int held_by_frames = 0;
  /// Why the poses stay as they are; nothing when they were made better.
  std::optional<std::string> refused;
};

/// As many frames as are looked at (as kMostFusedViews).
inline constexpr std::size_t kMostJointFrames = 16;

/// Least squares over the poses of up to kMostJointFrames frames (Ceres; those beyond keep theirs). Residuals, each in
/// sigma of the sensor's noise model: flat pieces of each frame from the planes of the expected depth, and from the
/// flat pieces that the other frames measured of the same surface, old or new (point to plane, Chen and Medioni 1992,
/// with the loss of Geman and McClure, so that what has changed has no say); and each pose from what its tracker says,
/// by its covariance. Directions that neither holds keep the tracker's. Refused, for all frames: when all poses count
/// as exact, when there is nothing to compare, when the distances do not become less, or when a correction is more than
/// five sigma of its pose. Frames have the camera's size; there must be one. Pure; 1 thread.
[[nodiscard]] JointPoses refine_poses(std::span<const PosedDepth> frames, const Camera& camera,
                                      const SensorModel& sensor);

}  // namespace meshloop
