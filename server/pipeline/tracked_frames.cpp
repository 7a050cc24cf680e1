#include "server/pipeline/tracked_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "common/base/clock.h"
#include "common/base/log.h"

namespace meshloop {
namespace {

constexpr int kMaxUnreadable = 10;
// A given trajectory is taken as exact to this: metres and radians.
constexpr double kGivenPoseSigma = 1e-5;

TrackedPose given_pose(const Trajectory& trajectory, double timestamp_s) {
  TrackedPose tracked;
  tracked.timestamp_s = timestamp_s;
  const auto T_world_color = pose_at(trajectory, timestamp_s);
  if (!T_world_color) return tracked;
  tracked.state = TrackState::tracking;
  tracked.T_camera_world = T_world_color->inverse();
  tracked.covariance = PoseCovariance::Identity() * kGivenPoseSigma * kGivenPoseSigma;
  tracked.quality = 1;
  return tracked;
}

}  // namespace

TrackedFrames::TrackedFrames(std::unique_ptr<RgbdSource> source, std::optional<Trajectory> trajectory,
                             std::unique_ptr<RigTracker> tracker, bool skip_unreadable, bool has_reference)
    : source_{std::move(source)},
      trajectory_{std::move(trajectory)},
      tracker_{std::move(tracker)},
      skip_unreadable_{skip_unreadable},
      has_reference_{has_reference} {}

Result<TrackedFrames> TrackedFrames::create(std::unique_ptr<RgbdSource> source, PoseOptions options) {
  std::unique_ptr<RigTracker> tracker;
  if (!options.trajectory) {
    auto made = RigTracker::create(source->rig(), options.tracker);
    if (!made) return fail(made.error());
    tracker = std::move(*made);
  }
  const auto& markers = options.tracker.markers;
  const bool has_reference = options.trajectory || (markers && !markers->markers.empty());
  return TrackedFrames{std::move(source), std::move(options.trajectory), std::move(tracker), options.skip_unreadable,
                       has_reference};
}

TrackedPose TrackedFrames::color_pose_of(const RgbdFrame& frame) {
  return trajectory_ ? given_pose(*trajectory_, frame.color_timestamp_s) : tracker_->track(frame);
}

Result<std::optional<TrackedFrame>> TrackedFrames::track_one() {
  std::optional<Error> last_error;
  for (int unreadable = 0;;) {
    auto frame = source_->next();
    if (!frame) {
      if (!skip_unreadable_ || ++unreadable == kMaxUnreadable) return fail(frame.error());
      last_error = frame.error();
      log_warning("{}; going on with the next frame", frame.error().message);
      continue;
    }
    if (!*frame && last_error && !read_any_) return fail("no frame can be read", *last_error);
    if (!*frame) return std::nullopt;
    read_any_ = true;
    const Stopwatch watch;
    TrackedFrame tracked{std::move(**frame), {}, {}, 0, has_reference_};
    tracked.color_pose = color_pose_of(tracked.frame);
    tracked.track_ms = watch.milliseconds();
    return tracked;
  }
}

TrackedFrame TrackedFrames::finished(TrackedFrame frame, const ColorPoses& color) const {
  const double time_s = frame.frame.depth_timestamp_s;
  if (trajectory_) {  // exact at the depth time itself
    const TrackedPose exact = given_pose(*trajectory_, time_s);
    frame.depth_pose = depth_pose_at(rig(), {{}, exact, exact}, time_s);
  } else {
    frame.depth_pose = depth_pose_at(rig(), color, time_s);
  }
  return frame;
}

Status TrackedFrames::check_frames(const std::vector<int>& frames) const {
  const auto count = source_->frame_count();
  if (!count) return {};
  const auto beyond = std::lower_bound(frames.begin(), frames.end(), *count);
  if (beyond == frames.end()) return {};
  return fail(fmt::format("frame {} is not in the recording, which has frames 0 to {}", *beyond, *count - 1),
              ErrorKind::usage);
}

Result<std::optional<TrackedFrame>> TrackedFrames::next() {
  if (failure_) return fail(*failure_);
  if (!waiting_) {
    auto first = track_one();
    if (!first || !*first) return first;
    waiting_ = std::move(*first);
    past_poses_.fill({.timestamp_s = waiting_->color_pose.timestamp_s});
  }
  auto read = track_one();
  if (!read) failure_ = read.error();
  std::optional<TrackedFrame> following = read ? std::move(*read) : std::nullopt;

  const TrackedPose present = waiting_->color_pose;
  const bool depth_is_later = waiting_->frame.depth_timestamp_s >= waiting_->frame.color_timestamp_s;
  const bool look_ahead = depth_is_later && following;
  const auto& [earlier, previous] = past_poses_;
  ColorPoses color{earlier, previous, present};
  if (look_ahead) color = {previous, present, following->color_pose};
  TrackedFrame done = finished(std::move(*waiting_), color);
  past_poses_ = {previous, present};
  waiting_ = std::move(following);
  return done;
}

}  // namespace meshloop
