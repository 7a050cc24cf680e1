#pragma once
// Start pose and tracker, joined, with the account of what was tracked.
#include <deque>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/recording/trajectory.h"
#include "device/pipeline/start_pose.h"
#include "device/track/model_tracker.h"

namespace meshloop {

struct TrackRecord {
  int index = 0;
  TrackedPose pose;
  Revision revision = 0;
  double time_ms = 0;
};

/// One thread, that of the GPU context.
class TrackingSession {
 public:
  [[nodiscard]] static Result<TrackingSession> create(GpuContext& gpu, const Camera& camera, StartPose start);

  /// See ModelTracker.
  void warm_up(const Model& model) { tracker_->warm_up(model); }
  /// Tracks one frame; while lost, markers (if any were given) start the tracker again. A null model is lost.
  const TrackRecord& track(const ColorFrame& frame, const std::shared_ptr<const Model>& model);

  /// Of the newest frames: at most an hour at 30 a second.
  [[nodiscard]] const std::deque<TrackRecord>& records() const { return records_; }
  [[nodiscard]] std::size_t lost_frames() const;
  /// Poses of the frames that were not lost.
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] nlohmann::json frames_json() const;

 private:
  TrackingSession(std::unique_ptr<ModelTracker> tracker, const Camera& camera, StartPose start);

  std::unique_ptr<ModelTracker> tracker_;
  Camera camera_;
  StartPose start_;
  bool lost_ = true;
  std::deque<TrackRecord> records_;
};

/// Distance between tracked and true camera positions, over the frames that were not lost:
/// {"mean_error_m", "max_error_m", "within_1cm", "frames"}, the last two counts of frames; null where there is no
/// truth.
[[nodiscard]] nlohmann::json truth_json(const Trajectory& tracked, const std::optional<Trajectory>& truth);

}  // namespace meshloop
