#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
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
    const TrackedPose depth = depth_pose_at(rig, {{}, before, after}, 1.0 + 0.04 * s);
    ASSERT_EQ(depth.state, TrackState::tracking) << s;
    const Pose expected = rig.T_depth_color * exp(Twist{s * motion()}) * pose_a();
    EXPECT_LT((depth.T_camera_world.matrix() - expected.matrix()).norm(), 1e-9) << s;
    EXPECT_DOUBLE_EQ(depth.timestamp_s, 1.0 + 0.04 * s);
  }
}

TEST(DepthPoseAt, AddsTheCalibrationsCovariance) {
  Rig rig = rig_with_extrinsics();
  const TrackedPose color = known(1.0, pose_a());
  const auto before = depth_pose_at(rig, {{}, color, color}, 1.0).covariance;
  const Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Random();
  rig.covariance.T_depth_color = 1e-6 * A * A.transpose();
  const auto after = depth_pose_at(rig, {{}, color, color}, 1.0).covariance;
  EXPECT_TRUE((after - before).isApprox(rig.covariance.T_depth_color, 1e-9));
}

TEST(DepthPoseAt, IsLostFurtherThanHalfTheDistanceOutside) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(1.0, pose_a());
  const TrackedPose after = known(1.04, pose_a());
  EXPECT_EQ(depth_pose_at(rig, {{}, before, after}, 1.061).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, {{}, before, after}, 0.979).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, {{}, before, after}, std::nan("")).state, TrackState::lost);
}

TEST(DepthPoseAt, OneKnownPoseHoldsForAMomentWithLessCertainty) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(1.0, pose_a());
  const TrackedPose after = known(1.04, pose_a(), TrackState::lost);
  const TrackedPose held = depth_pose_at(rig, {{}, before, after}, 1.01);
  EXPECT_EQ(held.state, TrackState::tracking);
  EXPECT_LT((held.T_camera_world.matrix() - (rig.T_depth_color * pose_a()).matrix()).norm(), 1e-12);
  EXPECT_GT(held.covariance.trace(), depth_pose_at(rig, {{}, before, after}, 1.0).covariance.trace());
  EXPECT_EQ(depth_pose_at(rig, {{}, before, after}, 1.035).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, {{}, after, after}, 1.04).state, TrackState::lost);
  EXPECT_EQ(depth_pose_at(rig, {{}, before, before}, 1.015).state, TrackState::tracking);
}

/// A hand that swings: a third of a metre to and fro and a quarter of a radian, in about a second.
Pose swing(double time_s) {
  const double phase = 6 * time_s;
  const Twist twist = (Twist{} << 0.3 * std::sin(phase), 0.1 * std::cos(1.3 * phase), 0.05 * std::sin(0.7 * phase),
                       0.05 * std::cos(phase), 0.25 * std::sin(phase), 0.1 * std::sin(1.1 * phase))
                          .finished();
  return exp(twist) * pose_a();
}

Twist swing_error(double interval_s, double s, double time_s, const TrackedPose& earlier, TrackedPose* found) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(time_s, swing(time_s));
  const TrackedPose after = known(time_s + interval_s, swing(time_s + interval_s));
  *found = depth_pose_at(rig, {earlier, before, after}, time_s + s * interval_s);
  return log(found->T_camera_world * (rig.T_depth_color * swing(time_s + s * interval_s)).inverse());
}

TEST(DepthPoseAt, FollowsAMotionWhoseAccelerationIsConstant) {
  const Rig rig = rig_with_extrinsics();
  const auto at = [](double t) { return exp(Twist{(2 * t + 5 * t * t) * motion()}) * pose_a(); };
  const ColorPoses color{known(-0.05, at(-0.05)), known(0, at(0)), known(0.04, at(0.04))};
  for (const double t : {-0.01, 0.0, 0.01, 0.03, 0.05}) {
    const TrackedPose depth = depth_pose_at(rig, color, t);
    EXPECT_LT((depth.T_camera_world.matrix() - (rig.T_depth_color * at(t)).matrix()).norm(), 1e-9) << t;
  }
}

// Beyond the last one nothing holds the curve; least is gained there.
TEST(DepthPoseAt, AnEarlierPoseLeavesLessThanHalfOfTheErrorOfASwing) {
  for (const double s : {0.12, 0.5, 0.88, 1.12}) {
    double with_m = 0;
    double without_m = 0;
    for (double t = 1; t < 3; t += 0.01) {
      TrackedPose found;
      with_m += swing_error(0.1, s, t, known(t - 0.1, swing(t - 0.1)), &found).head<3>().squaredNorm();
      without_m += swing_error(0.1, s, t, {}, &found).head<3>().squaredNorm();
    }
    EXPECT_LT(with_m, without_m / 4) << s;
  }
}

// The stated uncertainty is meant for errors of this size: no larger on average, and not ten times smaller.
TEST(DepthPoseAt, KnowsHowFarASwingMayHaveTakenIt) {
  for (const bool has_earlier : {true, false}) {
    double sum = 0;
    int count = 0;
    for (double t = 1; t < 3; t += 0.01) {
      for (const double s : {0.12, 0.5, 0.88}) {
        TrackedPose found;
        const TrackedPose earlier = has_earlier ? known(t - 0.1, swing(t - 0.1)) : TrackedPose{};
        const Twist error = swing_error(0.1, s, t, earlier, &found);
        sum += error.dot(found.covariance.ldlt().solve(error));
        ++count;
      }
    }
    EXPECT_LT(sum / count, 6) << has_earlier;
    EXPECT_GT(sum / count, 0.06) << has_earlier;
  }
}

TEST(DepthPoseAt, DoesNotBendWithAPoseThatIsLostOrLongPast) {
  const Rig rig = rig_with_extrinsics();
  const TrackedPose before = known(1.0, pose_a());
  const TrackedPose after = known(1.04, exp(motion()) * pose_a());
  const auto straight = depth_pose_at(rig, {{}, before, after}, 1.02);
  const TrackedPose lost = known(0.96, pose_a(), TrackState::lost);
  const TrackedPose found_again = known(0.96, pose_a(), TrackState::relocalised);
  const TrackedPose long_past = known(0.9, pose_a());
  const TrackedPose just_before = known(0.99, pose_a());
  for (const auto& earlier : {lost, found_again, long_past, just_before, before}) {
    const auto depth = depth_pose_at(rig, {earlier, before, after}, 1.02);
    EXPECT_EQ(depth.T_camera_world.matrix(), straight.T_camera_world.matrix());
    EXPECT_EQ(depth.covariance, straight.covariance);
  }
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
    const TrackedPose depth = depth_pose_at(rig, {{}, drawn, drawn}, 1.0);
    const Twist error = log(depth.T_camera_world * (rig.T_depth_color * pose_a()).inverse());
    sum += error.dot(depth.covariance.ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kDraws, 6, 3 * std::sqrt(12.0 / kDraws));
}

// The same between three poses, whose errors are alike or independent: never more than was said.
TEST(DepthPoseAt, BoundsWhatThePosesErrorsBecome) {
  const Rig rig = rig_with_extrinsics();
  const Twist sigma = (Twist{} << 1e-3, 5e-3, 2e-3, 1e-3, 4e-3, 2e-3).finished();
  std::mt19937 random{5};
  std::normal_distribution<double> normal;
  const auto draw = [&] {
    Twist xi;
    for (int k = 0; k < 6; ++k) xi[k] = sigma[k] * normal(random);
    return xi;
  };
  for (const bool are_alike : {true, false}) {
    for (const double s : {0.5, 1.4}) {
      double sum = 0;
      constexpr int kDraws = 500;
      for (int i = 0; i < kDraws; ++i) {
        std::array<TrackedPose, 3> drawn;
        const Twist same = draw();
        for (std::size_t k = 0; k < 3; ++k) {
          drawn[k] = known(1 + 0.04 * static_cast<double>(k), exp(are_alike ? same : draw()) * pose_a());
          drawn[k].covariance = sigma.cwiseAbs2().asDiagonal();
        }
        const auto depth = depth_pose_at(rig, {drawn[0], drawn[1], drawn[2]}, 1.04 + 0.04 * s);
        const Twist error = log(depth.T_camera_world * (rig.T_depth_color * pose_a()).inverse());
        sum += error.dot(depth.covariance.ldlt().solve(error));
      }
      EXPECT_LT(sum / kDraws, 6 + 3 * std::sqrt(12.0 / kDraws)) << are_alike << ' ' << s;
    }
  }
}

}  // namespace
}  // namespace meshloop
