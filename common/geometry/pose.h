#pragma once
// Rigid transforms. `T_a_b` maps points in frame b to frame a. Metres, radians.
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace meshloop {

using Pose = Eigen::Isometry3d;
/// (v, w): translation part first, then rotation (Barfoot 2017, "State Estimation for Robotics", section 7.1).
using Twist = Eigen::Matrix<double, 6, 1>;
/// Covariance of a twist xi in T_estimated = exp(xi) * T_true: the perturbation lives in the frame on the left.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

[[nodiscard]] Pose make_pose(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation);
/// A camera at `eye` that looks at `target`: x right, y down, z forward. `up` must not be parallel to the view.
[[nodiscard]] Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up);

/// Exponential and logarithm of SE(3) (Barfoot 2017, equations 7.33 to 7.37). log(exp(xi)) = xi for |w| < pi.
[[nodiscard]] Pose exp(const Twist& xi);
[[nodiscard]] Twist log(const Pose& pose);

/// The pose a fraction `s` of the way from a to b on SE(3), with constant velocity. s outside 0..1 extrapolates.
[[nodiscard]] Pose interpolate(const Pose& a, const Pose& b, double s);

/// True when all entries are finite and the rotation is one (orthonormal, determinant 1) to 1e-6.
[[nodiscard]] bool is_rigid(const Pose& pose);

/// The matrix [p]x with [p]x q = p x q.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& p);

}  // namespace meshloop
