#pragma once
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/geometry/sensor_model.h"

namespace meshloop {

/// How certain a rig's calibration is. Zero: taken as exact.
struct CalibrationCovariance {
  /// Of the depth camera's (fx, fy, cx, cy), in pixels^2.
  Eigen::Matrix4d depth_intrinsics = Eigen::Matrix4d::Zero();
  /// Of the twist xi in T_depth_color estimated = exp(xi) * true.
  PoseCovariance T_depth_color = PoseCovariance::Zero();
};

/// A rigidly coupled pair of a depth and a colour camera.
struct Rig {
  Camera color;
  Camera depth;
  /// Metres per unit of the recorded depth images, whole numbers or float; at most 1.
  double depth_scale = 0.001;
  Pose T_depth_color = Pose::Identity();
  SensorModel sensor;
  /// True: depth already lies in the colour camera's pixels.
  bool depth_registered = false;
  CalibrationCovariance covariance;
};

/// Says what is wrong: cameras that are none, a pose that is not rigid, covariances that are not symmetric or have a
/// negative eigenvalue.
[[nodiscard]] Status validate(const Rig& rig);

}  // namespace meshloop
