#include "device/track/model_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "simulated_walk.h"

namespace meshloop {
namespace {

using test::distance_m;
using test::frame_at;
using test::model_of;
using test::pose_at;
using test::small_camera;
using test::walk;
using test::WalkResult;

constexpr double kStep_deg = 2;

class ModelTrackerTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto tracker = ModelTracker::create(*context_, small_camera(), {});
    ASSERT_TRUE(tracker) << tracker.error().message;
    tracker_ = std::move(*tracker);
  }

  TrackedPose track(double angle_deg, int index, const std::shared_ptr<const Model>& model) {
    return tracker_->track(frame_at(scene_, small_camera(), pose_at(angle_deg), index), model);
  }

  const simulation::Scene scene_ = simulation::make_demo_scene(1);
  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<ModelTracker> tracker_;
};

TEST_F(ModelTrackerTest, FollowsTheCameraToMillimetresWithTheRightModel) {
  const WalkResult result = walk(*tracker_, scene_, model_of(scene_, false), small_camera(), 24, kStep_deg);
  EXPECT_EQ(result.lost, 0);
  EXPECT_LT(result.mean_m, 0.004);
  EXPECT_LT(result.max_m, 0.012);
  EXPECT_GT(result.lowest_quality, 0.5);
}

TEST_F(ModelTrackerTest, IsNotPulledByWhatTheModelLacks) {
  const WalkResult result = walk(*tracker_, scene_, model_of(scene_, true), small_camera(), 20, kStep_deg);
  EXPECT_EQ(result.lost, 0);
  EXPECT_LT(result.mean_m, 0.01);
}

TEST_F(ModelTrackerTest, IsNotPulledByABoxThatWasMovedWhereTheRestFixesThePose) {
  constexpr double kFront_deg = -90;
  const auto moved = simulation::with_moved_object(scene_, "box", {0.02, 0, 0});
  const WalkResult result = walk(*tracker_, moved, model_of(scene_, false), small_camera(), 20, kStep_deg, kFront_deg);
  EXPECT_EQ(result.lost, 0);
  EXPECT_LT(result.mean_m, 0.01);
}

// Seen from the sideboard's narrow end the box fills the view and was moved along it; the long edges do not tell. The
// pose goes with the box then, and no farther than the box went.
TEST_F(ModelTrackerTest, IsPulledNoFartherThanTheBoxWasMovedWhereOnlyTheBoxTells) {
  const auto moved = simulation::with_moved_object(scene_, "box", {0.02, 0, 0});
  const WalkResult result = walk(*tracker_, moved, model_of(scene_, false), small_camera(), 8, kStep_deg);
  EXPECT_EQ(result.lost, 0);
  EXPECT_LT(result.max_m, 0.03);
}

TEST_F(ModelTrackerTest, FollowsWithAModelThatHasNoColors) {
  const auto model = test::without_colors(*model_of(scene_, false));
  const WalkResult result = walk(*tracker_, scene_, model, small_camera(), 15, kStep_deg);
  EXPECT_EQ(result.lost, 0);
  EXPECT_LT(result.mean_m, 0.015);
}

TEST_F(ModelTrackerTest, CorrectsAStartThatIsCentimetresOff) {
  const auto model = model_of(scene_, false);
  Twist off;
  off << 0.02, -0.015, 0.02, 0.01, 0.015, -0.01;
  tracker_->start_at(exp(off) * pose_at(0));
  const TrackedPose tracked = track(0, 0, model);
  ASSERT_EQ(tracked.state, TrackState::tracking);
  EXPECT_LT(distance_m(tracked.T_camera_world, pose_at(0)), 0.006);
}

TEST_F(ModelTrackerTest, ToleratesAnotherExposure) {
  const auto model = model_of(scene_, false);
  tracker_->start_at(pose_at(0));
  for (int i = 0; i < 6; ++i) {
    ColorFrame frame = frame_at(scene_, small_camera(), pose_at(i * kStep_deg), i);
    for (auto& pixel : frame.color.pixels()) {
      const auto darker = [](std::uint8_t v) { return static_cast<std::uint8_t>(20 + v * 0.55); };
      pixel = {darker(pixel.r), darker(pixel.g), darker(pixel.b)};
    }
    const TrackedPose tracked = tracker_->track(frame, model);
    ASSERT_EQ(tracked.state, TrackState::tracking) << i;
    EXPECT_LT(distance_m(tracked.T_camera_world, pose_at(i * kStep_deg)), 0.01) << i;
  }
}

TEST_F(ModelTrackerTest, SaysLostWhenTheSceneIsGoneAndFindsBack) {
  const auto model = model_of(scene_, false);
  tracker_->start_at(pose_at(0));
  for (int i = 0; i < 4; ++i) ASSERT_EQ(track(i * kStep_deg, i, model).state, TrackState::tracking);
  ColorFrame elsewhere;
  elsewhere.color = ColorImage{320, 240, {128, 128, 128}};
  simulation::add_color_noise(elsewhere.color, 6, 3);
  for (int i = 4; i < 7; ++i) {
    elsewhere.timestamp_s = i / 30.0;
    EXPECT_EQ(tracker_->track(elsewhere, model).state, TrackState::lost);
  }
  const TrackedPose back = track(4, 7, model);
  EXPECT_EQ(back.state, TrackState::relocalised);
  EXPECT_LT(distance_m(back.T_camera_world, pose_at(4)), 0.01);
  EXPECT_EQ(track(6, 8, model).state, TrackState::tracking);
}

TEST_F(ModelTrackerTest, NeverReportsAWrongPoseAfterAJump) {
  const auto model = model_of(scene_, false);
  tracker_->start_at(pose_at(0));
  for (int i = 0; i < 3; ++i) ASSERT_EQ(track(i * kStep_deg, i, model).state, TrackState::tracking);
  for (int i = 3; i < 6; ++i) {
    const TrackedPose tracked = track(130 + i, i, model);
    if (tracked.state == TrackState::lost) continue;
    EXPECT_LT(distance_m(tracked.T_camera_world, pose_at(130 + i)), 0.02) << i;
  }
}

TEST_F(ModelTrackerTest, FindsBackToAViewThatWasSeenLongAgo) {
  const auto model = model_of(scene_, false);
  tracker_->start_at(pose_at(0));
  int index = 0;
  for (; index < 16; ++index) {
    ASSERT_EQ(track(index * 2.5, index, model).state, TrackState::tracking) << index;
  }
  ColorFrame dark;
  dark.color = ColorImage{320, 240};
  dark.timestamp_s = ++index / 30.0;
  ASSERT_EQ(tracker_->track(dark, model).state, TrackState::lost);
  const TrackedPose back = track(1, index + 1, model);
  ASSERT_EQ(back.state, TrackState::relocalised);
  EXPECT_LT(distance_m(back.T_camera_world, pose_at(1)), 0.01);
}

TEST_F(ModelTrackerTest, GoesOnWhenANewRevisionArrives) {
  const auto before = model_of(scene_, true);
  const auto after = model_of(scene_, false);
  tracker_->start_at(pose_at(0));
  for (int i = 0; i < 8; ++i) {
    const TrackedPose tracked = track(i * kStep_deg, i, i < 4 ? before : after);
    ASSERT_EQ(tracked.state, TrackState::tracking) << i;
    EXPECT_LT(distance_m(tracked.T_camera_world, pose_at(i * kStep_deg)), 0.015) << i;
  }
}

TEST_F(ModelTrackerTest, IsLostWithoutAModelAndGoesOnWhenItIsThere) {
  tracker_->start_at(pose_at(0));
  EXPECT_EQ(track(0, 0, nullptr).state, TrackState::lost);
  EXPECT_EQ(track(0, 1, std::make_shared<Model>()).state, TrackState::lost);
  EXPECT_EQ(track(0, 2, model_of(scene_, false)).state, TrackState::relocalised);
}

TEST_F(ModelTrackerTest, IsLostWhereTheModelIsNotInSight) {
  const auto model = model_of(scene_, false);
  const Pose away = look_at({1.2, 0, 0.5}, {3, 0, 0.6}, Eigen::Vector3d::UnitZ()).inverse();
  tracker_->start_at(away);
  EXPECT_EQ(tracker_->track(frame_at(scene_, small_camera(), away, 0), model).state, TrackState::lost);
}

TEST_F(ModelTrackerTest, RefusesFramesOfAnotherSizeAndKeepsItsPlace) {
  const auto model = model_of(scene_, false);
  tracker_->start_at(pose_at(0));
  ASSERT_EQ(track(0, 0, model).state, TrackState::tracking);
  ColorFrame other;
  other.color = ColorImage{160, 120};
  EXPECT_EQ(tracker_->track(other, model).state, TrackState::lost);
  other.color = ColorImage{};
  EXPECT_EQ(tracker_->track(other, model).state, TrackState::lost);
  EXPECT_EQ(track(1, 2, model).state, TrackState::relocalised);
}

TEST_F(ModelTrackerTest, IsLostBeforeItIsStartedAndAfterAStartThatIsNoPose) {
  const auto model = model_of(scene_, false);
  EXPECT_EQ(track(0, 0, model).state, TrackState::lost);
  Pose broken = pose_at(0);
  broken.translation().x() = std::numeric_limits<double>::quiet_NaN();
  tracker_->start_at(broken);
  EXPECT_EQ(track(0, 1, model).state, TrackState::lost);
}

TEST_F(ModelTrackerTest, RefusesACameraAndOptionsThatMakeNoSense) {
  Camera camera = small_camera();
  camera.fx = -1;
  EXPECT_FALSE(ModelTracker::create(*context_, camera, {}));
  ModelTrackerOptions options;
  options.max_features = 3;
  const auto refused = ModelTracker::create(*context_, small_camera(), options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::usage);
}

}  // namespace
}  // namespace meshloop
