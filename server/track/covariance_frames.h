#pragma once
// Moving a pose's covariance from one frame to another. Used inside this stage.
#include "common/geometry/pose.h"

namespace meshloop {

/// exp(adjoint(T) xi) = T exp(xi) T^-1, for twists (v, w) (Barfoot 2017, equation 7.45).
[[nodiscard]] inline Eigen::Matrix<double, 6, 6> adjoint(const Pose& T) {
  Eigen::Matrix<double, 6, 6> Ad = Eigen::Matrix<double, 6, 6>::Zero();
  Ad.topLeftCorner<3, 3>() = T.linear();
  Ad.topRightCorner<3, 3>() = skew(T.translation()) * T.linear();
  Ad.bottomRightCorner<3, 3>() = T.linear();
  return Ad;
}

/// A covariance of twists in frame b, as one in frame a.
[[nodiscard]] inline PoseCovariance moved(const Pose& T_a_b, const PoseCovariance& in_b) {
  const Eigen::Matrix<double, 6, 6> Ad = adjoint(T_a_b);
  return Ad * in_b * Ad.transpose();
}

}  // namespace meshloop
