#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace meshloop {

struct PointObservation {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  /// Undistorted pixel.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  /// Standard deviation of the pixel.
  double sigma_px = 1;
};

struct RobustPoseOptions {
  /// Beyond this a point counts as an outlier.
  double max_error_px = 3;
  int min_inliers = 12;
  int iterations = 20;
};

struct RobustPose {
  Pose T_camera_world = Pose::Identity();
  PoseCovariance covariance = PoseCovariance::Zero();
  std::vector<bool> inlier;
  int inliers = 0;
  /// Root mean square reprojection error of the inliers.
  double rms_px = 0;
};

/// Iteratively reweighted Gauss-Newton on SE(3) (Tukey's weights, analytic Jacobians) from a start that is nearly
/// right. Nothing when too few points agree, or when they do not fix all six degrees of freedom.
[[nodiscard]] std::optional<RobustPose> refine_pose(const std::vector<PointObservation>& points, const Camera& camera,
                                                    const Pose& start, const RobustPoseOptions& options);

/// The same without a trusted start: P3P in RANSAC, seeded and hence repeatable, then refine_pose.
[[nodiscard]] std::optional<RobustPose> find_pose(const std::vector<PointObservation>& points, const Camera& camera,
                                                  const RobustPoseOptions& options);

/// Reprojection residual (2) and its derivative to a twist on the left of T_camera_world (2x6); for tests and solvers.
struct ReprojectionTerm {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> jacobian;
};
[[nodiscard]] ReprojectionTerm reprojection(const PointObservation& point, const Camera& camera,
                                            const Pose& T_camera_world);

}  // namespace meshloop
