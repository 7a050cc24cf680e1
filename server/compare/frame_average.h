#pragma once
// The mean of several depth images of a camera at rest.
#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/camera.h"
#include "common/geometry/sensor_model.h"
#include "common/geometry/tracked_pose.h"
#include "common/image/image.h"

namespace meshloop {

struct AveragedDepth {
  /// Metres; 0 where fewer than half of the frames measured one and the same surface.
  DepthImage mean;
  /// Of how many measurements; 0 where there is no mean.
  Image<std::uint8_t> frames;
  /// How many frames were averaged.
  int count = 0;
};

/// Collects the frames of one average. Values that are not depths (0, negative, infinite, not a number) count as not
/// measured. Along depth edges a pixel sees now one surface, now another: the mean is taken over the measurements
/// within three sigma of their median, never between two surfaces. One thread.
class FrameAverage {
 public:
  static constexpr int kMostFrames = 64;

  /// camera: pinhole intrinsics of the depth camera.
  FrameAverage(const Camera& camera, const SensorModel& sensor) : camera_{camera}, sensor_{sensor} {}

  /// Refuses an image of another size than the camera's, a lost pose, more than kMostFrames frames, and a camera that
  /// moved since the first frame: by more than half a pixel or a quarter of the sensor's sigma at two metres, beyond
  /// three sigma of the two poses.
  [[nodiscard]] Status add(const DepthImage& measured, const TrackedPose& pose);

  [[nodiscard]] int count() const { return static_cast<int>(frames_.size()); }
  /// The pose of the first frame. There must be one.
  [[nodiscard]] const TrackedPose& pose() const { return *pose_; }
  [[nodiscard]] AveragedDepth result() const;
  void reset();

 private:
  [[nodiscard]] Status check_rest(const TrackedPose& pose) const;

  Camera camera_;
  SensorModel sensor_;
  std::optional<TrackedPose> pose_;
  std::vector<DepthImage> frames_;
};

}  // namespace meshloop
