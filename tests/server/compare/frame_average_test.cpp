#include "server/compare/frame_average.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "compare_scene.h"

namespace meshloop {
namespace {

using namespace compare_test;

class FrameAverageTest : public testing::Test {
 protected:
  FrameAverageTest() { pose_.state = TrackState::tracking; }
  DepthImage flat(float z_m) const { return DepthImage(32, 24, z_m); }
  Status add(const DepthImage& depth) { return average_.add(depth, pose_); }

  Camera camera_{32, 24, 30, 30, 15.5, 11.5, {}};
  SensorModel sensor_{SensorModel::Kind::kinect1};
  FrameAverage average_{camera_, sensor_};
  TrackedPose pose_;
};

TEST_F(FrameAverageTest, NoiseOfTheMeanFallsWithTheRootOfTheFrames) {
  std::mt19937 random{7};
  std::normal_distribution<double> noise{0, 0.004};
  for (int i = 0; i < 25; ++i) {
    DepthImage depth = flat(2);
    for (float& z : depth.pixels()) z += static_cast<float>(noise(random));
    ASSERT_TRUE(add(depth));
  }
  const auto result = average_.result();
  double squares = 0;
  for (const float z : result.mean.pixels()) squares += std::pow(static_cast<double>(z) - 2, 2);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(result.mean.size())), 0.004 / 5, 0.0001);
  EXPECT_EQ(result.count, 25);
}

TEST_F(FrameAverageTest, WhatIsNoDepthIsLeftOut) {
  const float bad[] = {0, -1, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
  for (int i = 0; i < 8; ++i) {
    DepthImage depth = flat(1);
    if (i < 4) depth(3, 3) = bad[i];
    if (i < 5) depth(4, 4) = 0;
    ASSERT_TRUE(add(depth));
  }
  const auto result = average_.result();
  EXPECT_EQ(result.mean(3, 3), 1);
  EXPECT_EQ(result.frames(3, 3), 4);
  EXPECT_EQ(result.mean(4, 4), 0);
  EXPECT_EQ(result.frames(4, 4), 0);
  EXPECT_EQ(result.frames(5, 5), 8);
}

TEST_F(FrameAverageTest, EdgePixelTakesTheSurfaceItSeesMoreOftenAndNeverAMixture) {
  for (int i = 0; i < 9; ++i) {
    DepthImage depth = flat(1);
    if (i % 3 == 0) depth(3, 3) = 2;
    if (i % 2 == 0) depth(4, 4) = 2;
    ASSERT_TRUE(add(depth));
  }
  const auto result = average_.result();
  EXPECT_EQ(result.mean(3, 3), 1);
  EXPECT_EQ(result.frames(3, 3), 6);
  EXPECT_EQ(result.mean(4, 4), 2);
  EXPECT_EQ(result.frames(4, 4), 5);
}

TEST_F(FrameAverageTest, CameraThatMovedIsRefusedAndNamed) {
  ASSERT_TRUE(add(flat(1)));
  // At two metres, and 30 pixels to a metre there: half a pixel are 33 mm.
  pose_.T_camera_world.translation().x() = 0.03;
  EXPECT_TRUE(add(flat(1)));
  pose_.T_camera_world.translation().x() = 0.04;
  const auto sideways = add(flat(1));
  ASSERT_FALSE(sideways);
  EXPECT_THAT(sideways.error().message, testing::HasSubstr("the camera moved"));
  pose_.T_camera_world.translation() = Eigen::Vector3d{0, 0, 0.002};
  EXPECT_FALSE(add(flat(1)));
  pose_.T_camera_world.translation() = Eigen::Vector3d{0, 0, 0.001};
  EXPECT_TRUE(add(flat(1)));
  EXPECT_EQ(average_.count(), 3);
}

TEST_F(FrameAverageTest, MotionThatThePosesUncertaintyExplainsIsNone) {
  pose_.covariance = 1e-6 * PoseCovariance::Identity();
  ASSERT_TRUE(add(flat(1)));
  pose_.T_camera_world.translation().z() = 0.003;
  EXPECT_TRUE(add(flat(1)));
}

TEST_F(FrameAverageTest, RefusesOtherSizesLostPosesAndTooManyFrames) {
  EXPECT_FALSE(average_.add(DepthImage(16, 16, 1.0F), pose_));
  TrackedPose lost;
  EXPECT_FALSE(average_.add(flat(1), lost));
  for (int i = 0; i < FrameAverage::kMostFrames; ++i) ASSERT_TRUE(add(flat(1)));
  EXPECT_FALSE(add(flat(1)));
  average_.reset();
  EXPECT_EQ(average_.count(), 0);
  EXPECT_TRUE(add(flat(1)));
}

}  // namespace
}  // namespace meshloop
