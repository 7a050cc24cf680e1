#include "common/geometry/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace meshloop {
namespace {

constexpr double kPi = std::numbers::pi;

Twist random_twist(std::mt19937& random, double angle) {
  std::uniform_real_distribution<double> uniform{-1, 1};
  Twist xi;
  for (int i = 0; i < 6; ++i) xi[i] = uniform(random);
  xi.tail<3>() = angle * xi.tail<3>().normalized();
  return xi;
}

// The matrix exponential's own series, which shares nothing with the closed form.
Eigen::Matrix4d series(const Twist& xi) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A.topLeftCorner<3, 3>() = skew(xi.tail<3>());
  A.topRightCorner<3, 1>() = xi.head<3>();
  Eigen::Matrix4d term = Eigen::Matrix4d::Identity();
  Eigen::Matrix4d sum = term;
  for (int i = 1; i < 60; ++i) {
    term = term * A / i;
    sum += term;
  }
  return sum;
}

TEST(Pose, ExpEqualsTheMatrixExponentialAtAllAngles) {
  std::mt19937 random{1};
  for (const double angle : {0.0, 1e-12, 1e-8, 1e-6, 9e-6, 1.1e-5, 1e-4, 1e-3, 0.1, 1.0, 3.0, kPi, 6.0}) {
    const Twist xi = random_twist(random, angle);
    EXPECT_LT((exp(xi).matrix() - series(xi)).cwiseAbs().maxCoeff(), 1e-13) << "angle " << angle;
  }
}

TEST(Pose, LogUndoesExpBelowHalfATurn) {
  std::mt19937 random{2};
  for (const double angle : {0.0, 1e-9, 1e-6, 1e-5, 1e-4, 1e-2, 1.0, 3.0, 3.14, kPi - 1e-6}) {
    const Twist xi = random_twist(random, angle);
    EXPECT_LT((log(exp(xi)) - xi).cwiseAbs().maxCoeff(), 1e-9) << "angle " << angle;
  }
}

TEST(Pose, LogOfHalfATurnIsFiniteAndLeadsBack) {
  for (const Eigen::Vector3d axis : {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()}) {
    Pose half = Pose::Identity();
    half.linear() = Eigen::AngleAxisd(kPi, axis).toRotationMatrix();
    half.translation() = Eigen::Vector3d{1, 2, 3};
    EXPECT_LT((exp(log(half)).matrix() - half.matrix()).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Pose, InterpolatesWithConstantVelocity) {
  std::mt19937 random{3};
  const Pose a = exp(random_twist(random, 2.0));
  const Twist velocity = random_twist(random, 1.5);
  const Pose b = a * exp(velocity);
  for (const double s : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5}) {
    const Pose expected = a * exp(s * velocity);
    EXPECT_LT((interpolate(a, b, s).matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-12) << s;
  }
}

TEST(Pose, LooksAtTheTargetWithTheImageUpright) {
  const Eigen::Vector3d eye{1, -2, 1.5};
  const Eigen::Vector3d target{0.2, 0.1, 0.3};
  const Pose T_world_camera = look_at(eye, target, Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(is_rigid(T_world_camera));
  const Eigen::Vector3d p_camera = T_world_camera.inverse() * target;
  EXPECT_NEAR(p_camera.x(), 0, 1e-12);
  EXPECT_NEAR(p_camera.y(), 0, 1e-12);
  EXPECT_NEAR(p_camera.z(), (target - eye).norm(), 1e-12);
  const Eigen::Vector3d above = T_world_camera.inverse() * (target + Eigen::Vector3d{0, 0, 0.1});
  EXPECT_LT(above.y(), 0) << "y points down in the picture";
  EXPECT_NEAR(above.x(), 0, 1e-12);
}

TEST(Pose, MakesAUnitRotationOfAnyQuaternion) {
  const Pose pose = make_pose({1, 2, 3}, Eigen::Quaterniond{2, 0, 0, 2});
  EXPECT_TRUE(is_rigid(pose));
  EXPECT_TRUE((pose * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d{1, 3, 3}, 1e-12));
}

TEST(Pose, IsRigidRefusesNaNScaleShearAndMirrors) {
  EXPECT_TRUE(is_rigid(Pose::Identity()));
  Pose pose = Pose::Identity();
  pose.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_rigid(pose));
  pose = Pose::Identity();
  pose.linear() *= 1.001;
  EXPECT_FALSE(is_rigid(pose));
  pose = Pose::Identity();
  pose.linear()(0, 1) = 0.01;
  EXPECT_FALSE(is_rigid(pose));
  pose = Pose::Identity();
  pose.linear()(2, 2) = -1;
  EXPECT_FALSE(is_rigid(pose));
}

TEST(Pose, SkewIsTheCrossProduct) {
  const Eigen::Vector3d p{1, 2, 3};
  const Eigen::Vector3d q{-4, 5, 0.5};
  EXPECT_EQ(skew(p) * q, p.cross(q));
}

}  // namespace
}  // namespace meshloop
