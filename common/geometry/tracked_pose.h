#pragma once
#include <string_view>

#include "common/geometry/pose.h"

namespace meshloop {

enum class TrackState { lost, tracking, relocalised };

[[nodiscard]] constexpr std::string_view name_of(TrackState state) {
  switch (state) {
    case TrackState::tracking:
      return "tracking";
    case TrackState::relocalised:
      return "relocalised";
    case TrackState::lost:
      break;
  }
  return "lost";
}

/// A camera's pose at one moment, and how far to trust it.
struct TrackedPose {
  double timestamp_s = 0;
  TrackState state = TrackState::lost;
  /// The camera's frame; meaningless when lost.
  Pose T_camera_world = Pose::Identity();
  PoseCovariance covariance = PoseCovariance::Zero();
  /// 0 (worst) to 1; the share of observations that agree with the pose, not derived from the covariance.
  double quality = 0;
  int inliers = 0;
};

}  // namespace meshloop
