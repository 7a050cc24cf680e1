#include "common/geometry/pose.h"

#include <cmath>

namespace meshloop {
namespace {

constexpr double kSmallAngle = 1e-5;

// The matrix V with exp(v, w) = (exp(w), V v).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d W = skew(w);
  if (angle < kSmallAngle) return Eigen::Matrix3d::Identity() + 0.5 * W + W * W / 6.0;
  // 1 - cos(angle) loses its digits at small angles; twice the square of the half angle's sine does not.
  const double half_chord = std::sin(angle / 2) / angle;
  return Eigen::Matrix3d::Identity() + 2.0 * half_chord * half_chord * W +
         (angle - std::sin(angle)) / (angle * angle * angle) * W * W;
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& p) {
  Eigen::Matrix3d m;
  m << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  return m;
}

Pose make_pose(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = z.cross(up).normalized();
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear().col(0) = x;
  T_world_camera.linear().col(1) = z.cross(x);
  T_world_camera.linear().col(2) = z;
  T_world_camera.translation() = eye;
  return T_world_camera;
}

Pose exp(const Twist& xi) {
  const Eigen::Vector3d w = xi.tail<3>();
  const double angle = w.norm();
  Pose pose = Pose::Identity();
  if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  pose.translation() = left_jacobian(w) * xi.head<3>();
  return pose;
}

Twist log(const Pose& pose) {
  const Eigen::AngleAxisd rotation(Eigen::Quaterniond(pose.linear()).normalized());
  const Eigen::Vector3d w = rotation.angle() * rotation.axis();
  Twist xi;
  xi.head<3>() = left_jacobian(w).partialPivLu().solve(pose.translation());
  xi.tail<3>() = w;
  return xi;
}

Pose interpolate(const Pose& a, const Pose& b, double s) {
  return a * exp(s * log(a.inverse() * b));
}

bool is_rigid(const Pose& pose) {
  if (!pose.matrix().allFinite()) return false;
  const Eigen::Matrix3d R = pose.linear();
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 && R.determinant() > 0;
}

}  // namespace meshloop
