#include "device/pipeline/tracking_session.h"

#include <algorithm>
#include <utility>

#include "common/base/clock.h"

namespace meshloop {
namespace {

constexpr std::size_t kMaxRecords = 108'000;

}  // namespace

TrackingSession::TrackingSession(std::unique_ptr<ModelTracker> tracker, const Camera& camera, StartPose start)
    : tracker_{std::move(tracker)}, camera_{camera}, start_{std::move(start)} {}

Result<TrackingSession> TrackingSession::create(GpuContext& gpu, const Camera& camera, StartPose start) {
  auto tracker = ModelTracker::create(gpu, camera, {});
  if (!tracker) return fail(tracker.error());
  return TrackingSession{std::move(*tracker), camera, std::move(start)};
}

const TrackRecord& TrackingSession::track(const ColorFrame& frame, const std::shared_ptr<const Model>& model) {
  const Stopwatch watch;
  TrackRecord record;
  record.index = frame.index;
  record.pose.timestamp_s = frame.timestamp_s;
  if (model) {
    if (lost_) {
      if (const auto start = start_.find(frame, camera_)) tracker_->start_at(*start);
    }
    record.pose = tracker_->track(frame, model);
    record.pose.timestamp_s = frame.timestamp_s;
    record.revision = model->revision;
    lost_ = record.pose.state == TrackState::lost;
  }
  record.time_ms = watch.milliseconds();
  records_.push_back(record);
  if (records_.size() > kMaxRecords) records_.pop_front();
  return records_.back();
}

std::size_t TrackingSession::lost_frames() const {
  return static_cast<std::size_t>(std::count_if(records_.begin(), records_.end(), [](const TrackRecord& record) {
    return record.pose.state == TrackState::lost;
  }));
}

Trajectory TrackingSession::trajectory() const {
  Trajectory trajectory;
  for (const auto& record : records_) {
    if (record.pose.state == TrackState::lost) continue;
    trajectory.push_back({record.pose.timestamp_s, record.pose.T_camera_world.inverse()});
  }
  return trajectory;
}

nlohmann::json TrackingSession::frames_json() const {
  nlohmann::json frames = nlohmann::json::array();
  for (const auto& record : records_) {
    frames.push_back({{"index", record.index},
                      {"timestamp", record.pose.timestamp_s},
                      {"state", name_of(record.pose.state)},
                      {"quality", record.pose.quality},
                      {"inliers", record.pose.inliers},
                      {"revision", record.revision},
                      {"time_ms", record.time_ms}});
  }
  return frames;
}

nlohmann::json truth_json(const Trajectory& tracked, const std::optional<Trajectory>& truth) {
  if (!truth) return nullptr;
  double sum = 0;
  double largest = 0;
  int frames = 0;
  int within_1cm = 0;
  for (const auto& pose : tracked) {
    const auto true_pose = pose_at(*truth, pose.timestamp_s);
    if (!true_pose) continue;
    const double error = (pose.T_world_camera.translation() - true_pose->translation()).norm();
    sum += error;
    largest = std::max(largest, error);
    within_1cm += error <= 0.01 ? 1 : 0;
    ++frames;
  }
  if (frames == 0) return nullptr;
  return {{"mean_error_m", sum / frames}, {"max_error_m", largest}, {"within_1cm", within_1cm}, {"frames", frames}};
}

}  // namespace meshloop
