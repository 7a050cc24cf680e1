#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "server/track/rig_tracker.h"

namespace meshloop {
namespace {

Rig rig_with_extrinsics() {
  Rig rig;
  rig.T_depth_color.translation() = Eigen::Vector3d{-0.025, 0.01, 0.003};
  rig.T_depth_color.linear() = Eigen::AngleAxisd{0.3, Eigen::Vector3d{1, 2, -1}.normalized()}.toRotationMatrix();
  return rig;
}

TrackedPose known(double time_s, const Pose& pose, TrackState state = TrackState::tracking) {
  TrackedPose known;
  known.timestamp_s = time_s;
  known.state = state;
  known.T_camera_world = pose;
  known.covariance = PoseCovariance::Identity() * 1e-6;
  known.quality = 0.9;
  known.inliers = 100;
  return known;
}

Pose pose_a() {
  return look_at({0.1, -0.2, -1}, {0, 0, 0.2}, {0, -1, 0}).inverse();
}
Twist motion() {
  return (Twist{} << 0.02, -0.01, 0.03, 0.05, 0.02, -0.04).finished();
}

TEST(DepthPoseAt, LiesOnTheWayBetweenTheColourPoses) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(1.0, pose_a());
  const TrackedPose after = known(1.04, exp(motion()) * pose_a());
  for (const double s : {0.0, 0.25, 1.0, -0.5, 1.5}) {
    const TrackedPose depth = depth_pose_at(rig, before, after, 1.0 + 0.04 * s);
    ASSERT_EQ(depth.state, TrackState::tracking) << s;
    const Pose expected = rig.T_depth_color * exp(Twist{s * motion()}) * pose_a();
    EXPECT_LT((depth.T_camera_world.matrix() - expected.matrix()).norm(), 1e-9) << s;
    EXPECT_DOUBLE_EQ(depth.timestamp_s, 1.0 + 0.04 * s);
  }
}

TEST(DepthPoseAt, AddsTheCalibrationsCovariance) {
  Rig rig = rig_with_extrinsics();
  const TrackedPose color = known(1.0, pose_a());
  const auto before = depth_pose_at(rig, color, color, 1.0).covariance;
  const Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Random();
  rig.covariance.T_depth_color = 1e-6 * A * A.transpose();
  const auto after = depth_pose_at(rig, color, color, 1.0).covariance;
  EXPECT_TRUE((after - before).isApprox(rig.covariance.T_depth_color, 1e-9));
}

TEST(DepthPoseAt, IsLostFurtherThanHalfTheDistanceOutside) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(1.0, pose_a());
  const TrackedPose after = known(1.04, pose_a());
  EXPECT_EQ(depth_pose_at(rig, before, after, 1.061).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, before, after, 0.979).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, before, after, std::nan("")).state, TrackState::lost);
}

TEST(DepthPoseAt, OneKnownPoseHoldsForAMomentWithLessCertainty) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(1.0, pose_a());
  const TrackedPose after = known(1.04, pose_a(), TrackState::lost);
  const TrackedPose held = depth_pose_at(rig, before, after, 1.01);
  EXPECT_EQ(held.state, TrackState::tracking);
  EXPECT_LT((held.T_camera_world.matrix() - (rig.T_depth_color * pose_a()).matrix()).norm(), 1e-12);
  EXPECT_GT(held.covariance.trace(), depth_pose_at(rig, before, after, 1.0).covariance.trace());
  EXPECT_EQ(depth_pose_at(rig, before, after, 1.035).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, after, after, 1.04).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, before, before, 1.015).state, TrackState::tracking);
}

// Colour poses drawn from their covariance: the depth poses' errors must fit the covariance that was carried over.
TEST(DepthPoseAt, CarriesTheCovarianceIntoTheDepthFrame) {
  const Rig rig = rig_with_extrinsics();
  TrackedPose color = known(1.0, pose_a());
  const Twist sigma = (Twist{} << 1e-3, 5e-3, 2e-3, 1e-3, 4e-3, 2e-3).finished();
  color.covariance = sigma.cwiseAbs2().asDiagonal();
  std::mt19937 random{3};
  std::normal_distribution<double> normal;
  double sum = 0;
  constexpr int kDraws = 500;
  for (int i = 0; i < kDraws; ++i) {
    TrackedPose drawn = color;
    Twist xi;
    for (int k = 0; k < 6; ++k) xi[k] = sigma[k] * normal(random);
    drawn.T_camera_world = exp(xi) * pose_a();
    const TrackedPose depth = depth_pose_at(rig, drawn, drawn, 1.0);
    const Twist error = log(depth.T_camera_world * (rig.T_depth_color * pose_a()).inverse());
    sum += error.dot(depth.covariance.ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kDraws, 6, 3 * std::sqrt(12.0 / kDraws));
}

}  // namespace
}  // namespace meshloop
