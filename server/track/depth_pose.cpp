#include <algorithm>
#include <cmath>

#include "server/track/covariance_frames.h"
#include "server/track/rig_tracker.h"

namespace meshloop {
namespace {

// A pose known at one time only holds this long, at the least; the rig may have moved meanwhile as a hand moves.
constexpr double kLongestHold_s = 0.02;
constexpr double kHandSpeed_m_s = 0.2;
constexpr double kHandTurn_rad_s = 0.4;

TrackedPose lost_at(double timestamp_s) {
  TrackedPose lost;
  lost.timestamp_s = timestamp_s;
  return lost;
}

TrackedPose seen_from_depth(const Rig& rig, TrackedPose color) {
  color.T_camera_world = rig.T_depth_color * color.T_camera_world;
  // Both perturbations act on the left, in the depth camera's frame.
  color.covariance = moved(rig.T_depth_color, color.covariance) + rig.covariance.T_depth_color;
  return color;
}

TrackedPose hold(const TrackedPose& known, double timestamp_s, double longest_s) {
  const double gap = std::abs(timestamp_s - known.timestamp_s);
  if (!(gap <= longest_s)) return lost_at(timestamp_s);
  TrackedPose held = known;
  held.timestamp_s = timestamp_s;
  held.covariance.diagonal().head<3>().array() += kHandSpeed_m_s * gap * kHandSpeed_m_s * gap;
  held.covariance.diagonal().tail<3>().array() += kHandTurn_rad_s * gap * kHandTurn_rad_s * gap;
  return held;
}

}  // namespace

TrackedPose depth_pose_at(const Rig& rig, const TrackedPose& color_before, const TrackedPose& color_after,
                          double depth_timestamp_s) {
  const bool before_known = color_before.state != TrackState::lost;
  const bool after_known = color_after.state != TrackState::lost;
  if (!before_known && !after_known) return lost_at(depth_timestamp_s);
  const double distance_s = color_after.timestamp_s - color_before.timestamp_s;
  if (before_known != after_known || !(distance_s > 0)) {
    const TrackedPose held =
        hold(after_known ? color_after : color_before, depth_timestamp_s, std::max(kLongestHold_s, 0.5 * distance_s));
    return held.state == TrackState::lost ? held : seen_from_depth(rig, held);
  }
  const double s = (depth_timestamp_s - color_before.timestamp_s) / distance_s;
  if (!(s >= -0.5 && s <= 1.5)) return lost_at(depth_timestamp_s);
  TrackedPose color;
  color.timestamp_s = depth_timestamp_s;
  const bool both_tracking = color_before.state == TrackState::tracking && color_after.state == TrackState::tracking;
  color.state = both_tracking ? TrackState::tracking : TrackState::relocalised;
  color.T_camera_world = interpolate(color_before.T_camera_world, color_after.T_camera_world, s);
  // The two errors come from the same points, so how they correlate is unknown: this bound holds for any correlation.
  const double before = std::abs(1 - s);
  const double after = std::abs(s);
  color.covariance = (before + after) * (before * color_before.covariance + after * color_after.covariance);
  color.quality = std::min(color_before.quality, color_after.quality);
  color.inliers = std::min(color_before.inliers, color_after.inliers);
  return seen_from_depth(rig, color);
}

}  // namespace meshloop
