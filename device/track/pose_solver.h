#pragma once
// Pose from points and from edges together.
#include <optional>
#include <vector>

#include "common/features/robust_pose.h"

namespace meshloop {

/// A world point that lies on an edge in the picture. Along the edge it may be anywhere: only the distance across
/// counts.
struct EdgeObservation {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  /// A point of the edge in the picture, and the edge's unit normal there.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
  double sigma_px = 1;
};

struct JointPose {
  Pose T_camera_world = Pose::Identity();
  /// Of a twist on the left, as in TrackedPose. Large where the observations leave a direction open.
  PoseCovariance covariance = PoseCovariance::Zero();
  /// Within max_error_px, hence used.
  int points = 0;
  int edges = 0;
};

struct JointOptions {
  double max_error_px = 3;
  int iterations = 12;
};

/// Iteratively reweighted Gauss-Newton with Tukey's weights (Drummond, Cipolla 2002, for the edges' term), from a start
/// that is nearly right. Nothing when the observations do not fix the pose, or it leaves the numbers' range.
[[nodiscard]] std::optional<JointPose> solve_pose(const std::vector<PointObservation>& points,
                                                  const std::vector<EdgeObservation>& edges, const Camera& camera,
                                                  const Pose& start, const JointOptions& options);

/// Signed distance of the projected point from the edge, in pixels; infinite behind the camera.
[[nodiscard]] double edge_error_px(const EdgeObservation& edge, const Camera& camera, const Pose& T_camera_world);

}  // namespace meshloop
