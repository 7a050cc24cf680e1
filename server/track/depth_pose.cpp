#include <algorithm>
#include <array>
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

bool is_known(const TrackedPose& pose) {
  return pose.state != TrackState::lost;
}

TrackedPose seen_from_depth(const Rig& rig, TrackedPose color) {
  color.T_camera_world = rig.T_depth_color * color.T_camera_world;
  // Both perturbations act on the left, in the depth camera's frame.
  color.covariance = moved(rig.T_depth_color, color.covariance) + rig.covariance.T_depth_color;
  return color;
}

// One sigma in every direction.
void add_uncertainty(TrackedPose& pose, double shift_m, double turn_rad) {
  pose.covariance.diagonal().head<3>().array() += shift_m * shift_m;
  pose.covariance.diagonal().tail<3>().array() += turn_rad * turn_rad;
}

TrackedPose hold(const TrackedPose& known, double timestamp_s, double longest_s) {
  const double gap = std::abs(timestamp_s - known.timestamp_s);
  if (!(gap <= longest_s)) return lost_at(timestamp_s);
  TrackedPose held = known;
  held.timestamp_s = timestamp_s;
  add_uncertainty(held, kHandSpeed_m_s * gap, kHandTurn_rad_s * gap);
  return held;
}

/// How the pose at a time follows from the colour poses: exp of the sum of their twists, each with its weight, from
/// `before` on.
struct Curve {
  /// Of earlier, before and after; their sum is 1 (Lagrange's polynomials).
  std::array<double, 3> weights;
  Twist twist;
  /// How far the motion may have taken the rig from the curve, one sigma.
  double shift_m;
  double turn_rad;
};

/// `s`: 0 at before, 1 at after. The velocity may change by as much as it is.
Curve line(const ColorPoses& color, double s) {
  const Twist step = log(color.after.T_camera_world * color.before.T_camera_world.inverse());
  const double change = std::abs(s * (1 - s)) / 2;
  return {{0, 1 - s, s}, s * step, change * step.head<3>().norm(), change * step.tail<3>().norm()};
}

/// The acceleration may change by a quarter of what it is, in each direction: over all three a third was the root mean
/// square where a hand swings.
Curve parabola(const ColorPoses& color, double s) {
  constexpr double kChange = 0.25;
  const Twist step = log(color.after.T_camera_world * color.before.T_camera_world.inverse());
  const Twist back = log(color.earlier.T_camera_world * color.before.T_camera_world.inverse());
  // Times in units of the distance from before to after.
  const double r =
      (color.before.timestamp_s - color.earlier.timestamp_s) / (color.after.timestamp_s - color.before.timestamp_s);
  const double earlier = s * (s - 1) / (r * (r + 1));
  const double after = s * (s + r) / (1 + r);
  const Twist twist = earlier * back + after * step;
  const Twist bend = twist - s * step;
  return {
      {earlier, 1 - earlier - after, after}, twist, kChange * bend.head<3>().norm(), kChange * bend.tail<3>().norm()};
}

Curve curve_through(const ColorPoses& color, double s) {
  // Further back the motion was another one; nearer by, noise of the poses would count many times over.
  constexpr double kLongest = 2;
  constexpr double kShortest = 0.5;
  const double interval_s = color.after.timestamp_s - color.before.timestamp_s;
  const double before_s = color.before.timestamp_s - color.earlier.timestamp_s;
  const bool all_track = color.earlier.state == TrackState::tracking && color.before.state == TrackState::tracking &&
                         color.after.state == TrackState::tracking;
  return all_track && before_s >= kShortest * interval_s && before_s <= kLongest * interval_s ? parabola(color, s)
                                                                                              : line(color, s);
}

}  // namespace

TrackedPose depth_pose_at(const Rig& rig, const ColorPoses& color, double depth_timestamp_s) {
  const auto& [earlier, before, after] = color;
  if (!is_known(before) && !is_known(after)) return lost_at(depth_timestamp_s);
  const double distance_s = after.timestamp_s - before.timestamp_s;
  if (is_known(before) != is_known(after) || !(distance_s > 0)) {
    const TrackedPose held =
        hold(is_known(after) ? after : before, depth_timestamp_s, std::max(kLongestHold_s, 0.5 * distance_s));
    return is_known(held) ? seen_from_depth(rig, held) : held;
  }
  const double s = (depth_timestamp_s - before.timestamp_s) / distance_s;
  if (!(s >= -0.5 && s <= 1.5)) return lost_at(depth_timestamp_s);
  const Curve curve = curve_through(color, s);
  TrackedPose pose;
  pose.timestamp_s = depth_timestamp_s;
  const bool both_tracking = before.state == TrackState::tracking && after.state == TrackState::tracking;
  pose.state = both_tracking ? TrackState::tracking : TrackState::relocalised;
  pose.T_camera_world = exp(curve.twist) * before.T_camera_world;
  // The errors come from the same points, so how they correlate is unknown: this bound holds for any correlation.
  const auto [e, b, a] = curve.weights;
  pose.covariance =
      (std::abs(e) + std::abs(b) + std::abs(a)) *
      (std::abs(e) * earlier.covariance + std::abs(b) * before.covariance + std::abs(a) * after.covariance);
  add_uncertainty(pose, curve.shift_m, curve.turn_rad);
  pose.quality = std::min(before.quality, after.quality);
  pose.inliers = std::min(before.inliers, after.inliers);
  return seen_from_depth(rig, pose);
}

}  // namespace meshloop
