#pragma once
// The snapshot's pose, made better by what of the model has not changed.
#include <Eigen/Core>
#include <optional>
#include <string>

#include "server/adjust/proposal.h"

namespace meshloop {

/// What became of the pose.
struct Registration {
  /// From the world to the depth camera: the snapshot's own pose where it was refused.
  Pose T_camera_world = Pose::Identity();
  /// Root mean square distance of the measured points that agree from the model's planes, in metres.
  double before_m = 0;
  double after_m = 0;
  /// Measured points that agree in the end, of those that were looked at.
  int points = 0;
  int looked_at = 0;
  /// Directions in which the scene holds the camera, of six; the pose keeps what it had in the others.
  int held_directions = 0;
  /// The correction that the model asks for, also of an exact pose, used or not: what neither pose nor model know of
  /// themselves (2 mm, 2 mrad) is added to the pose's covariance. exp(found) acts on points of the camera; metres,
  /// radians.
  Twist found = Twist::Zero();
  /// How far the place that the points alone ask for lies from the snapshot's pose, in sigma of both together, in the
  /// directions that are held (the distance of Mahalanobis).
  double disagreement_sigmas = 0;
  /// Of the points that were looked at there, those that agree.
  double share_agreeing = 0;
  /// Of the points that the correction shifts visibly across the model's planes, the share that comes nearer to them: a
  /// wrong pose makes it nearly all of them, what moved only its own.
  double share_nearer = 0;
  /// Why the pose stays as it is; nothing when it was made better.
  std::optional<std::string> refused;
};

/// Point-to-plane ICP (Chen and Medioni 1992) of the measured depth against the expected one, which stands for the
/// model around the snapshot's pose, with Tukey's weights, so that what has changed has no say, and with the snapshot's
/// own pose as one more observation. In directions that the planes do not hold (along a bare corridor) that one alone
/// counts. Refused: when the pose has no covariance and so counts as exact, when less than a fifth of the points agree,
/// when they do not come nearer, or when the correction is more than five sigma. The snapshot must be valid.
[[nodiscard]] Registration refine_pose(const Snapshot& snapshot);

}  // namespace meshloop
