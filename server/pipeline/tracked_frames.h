#pragma once
// Frames with the depth camera's pose: capture and track, joined.
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/recording/trajectory.h"
#include "server/capture/rgbd_source.h"
#include "server/track/rig_tracker.h"

namespace meshloop {

/// Where the colour camera's poses come from: a trajectory (T_world_color), or the tracker.
struct PoseOptions {
  std::optional<Trajectory> trajectory;
  RigTrackerOptions tracker;
  /// Live, a frame that cannot be read is left out with a warning; in batch it is an error.
  bool skip_unreadable = false;
};

struct TrackedFrame {
  RgbdFrame frame;
  /// T_color_world at the colour image's time, T_depth_world at the depth image's.
  TrackedPose color_pose;
  TrackedPose depth_pose;
  double track_ms = 0;
  /// Markers or a trajectory hold the pose; else it goes back to a first pose that was given.
  bool has_reference = true;
};

/// A depth image is exposed between two colour images, so a frame comes out when the next one was tracked.
class TrackedFrames {
 public:
  [[nodiscard]] static Result<TrackedFrames> create(std::unique_ptr<RgbdSource> source, PoseOptions options);

  [[nodiscard]] const Rig& rig() const { return source_->rig(); }
  /// RgbdSource::calibration.
  [[nodiscard]] const Rig& calibration() const { return source_->calibration(); }
  /// An error of usage when the source is known to end before one of these frames (in growing order).
  [[nodiscard]] Status check_frames(const std::vector<int>& frames) const;
  /// Nothing at the end. With skip_unreadable a frame that cannot be read is left out with a warning; ten in a row, or
  /// no other frame at all, are an error. An error comes after the frames that were read before it, and stays.
  [[nodiscard]] Result<std::optional<TrackedFrame>> next();
  /// Whether `next` need not wait for the source.
  [[nodiscard]] bool ready() const { return failure_ || source_->ready(); }

 private:
  TrackedFrames(std::unique_ptr<RgbdSource> source, std::optional<Trajectory> trajectory,
                std::unique_ptr<RigTracker> tracker, bool skip_unreadable, bool has_reference);
  [[nodiscard]] Result<std::optional<TrackedFrame>> track_one();
  [[nodiscard]] TrackedPose color_pose_of(const RgbdFrame& frame);
  [[nodiscard]] TrackedFrame finished(TrackedFrame frame, const ColorPoses& color) const;

  std::unique_ptr<RgbdSource> source_;
  std::optional<Trajectory> trajectory_;
  std::unique_ptr<RigTracker> tracker_;
  bool skip_unreadable_;
  bool has_reference_;
  bool read_any_ = false;
  std::optional<TrackedFrame> waiting_;
  std::optional<Error> failure_;
  /// Of the two colour images before the waiting frame's; lost where there were none.
  std::array<TrackedPose, 2> past_poses_;
};

}  // namespace meshloop
