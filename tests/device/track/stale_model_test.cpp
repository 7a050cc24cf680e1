// A walk around a box that the model has 2 cm off, so near that the box fills half of the picture.
#include <gtest/gtest.h>

#include <utility>

#include "common/simulation/camera_path.h"
#include "simulated_walk.h"

namespace meshloop {
namespace {

using test::distance_m;
using test::model_of;

/// Frames of a full circle.
constexpr int kRound = 120;
/// From here on the box hides most of what did not move.
constexpr int kHalfWay = 45;
constexpr int kAllButRound = 90;

Pose pose_at(int index) {
  constexpr double kRound_s = 6;
  const simulation::DevicePath path{.round_s = kRound_s, .farthest_m = 0.57, .nearest_m = 0.45};
  return path.at(kRound_s * index / kRound).inverse();
}

class StaleModel : public testing::Test {
 protected:
  void start(const Camera& camera) {
    camera_ = camera;
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto tracker = ModelTracker::create(*context_, camera_, {});
    ASSERT_TRUE(tracker) << tracker.error().message;
    tracker_ = std::move(*tracker);
    tracker_->start_at(pose_at(0));
  }

  /// What the tracker says of the frame from `index` on the circle, and how far off it is in metres.
  std::pair<TrackedPose, double> track(int index, const std::shared_ptr<const Model>& model) {
    const Pose truth = pose_at(index);
    const TrackedPose tracked = tracker_->track(test::frame_at(moved_, camera_, truth, index), model);
    return {tracked, distance_m(tracked.T_camera_world, truth)};
  }

  const simulation::Scene scene_ = simulation::make_demo_scene(1);
  const simulation::Scene moved_ = simulation::with_moved_object(scene_, "box", {0.02, 0, 0});
  const std::shared_ptr<const Model> stale_ = model_of(scene_, false);
  Camera camera_;
  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<ModelTracker> tracker_;
};

// With every observation counted alike the mean error of the second half was 6.9 mm.
TEST_F(StaleModel, IsNotPulledByABoxThatFillsThePictureAndFindsBackBesideIt) {
  start({640, 480, 525, 525, 319.5, 239.5, {}});
  double sum_m = 0;
  for (int i = 0; i < kAllButRound; ++i) {
    const auto [tracked, error_m] = track(i, stale_);
    ASSERT_NE(tracked.state, TrackState::lost) << i;
    EXPECT_LT(error_m, 0.009) << i;
    if (i >= kHalfWay) sum_m += error_m;
  }
  EXPECT_LT(sum_m / (kAllButRound - kHalfWay), 0.005);

  // What is stale stays so in a model that changed elsewhere.
  const double quality = track(kAllButRound - 1, stale_).first.quality;
  const auto changed_elsewhere = model_of(scene_, false);
  const auto [tracked, error_still_m] = track(kAllButRound - 1, changed_elsewhere);
  EXPECT_EQ(tracked.state, TrackState::tracking);
  EXPECT_LT(error_still_m, 0.009);
  EXPECT_GT(tracked.quality, 0.95 * quality);

  ColorFrame covered;
  covered.color = ColorImage{640, 480};
  covered.timestamp_s = kAllButRound / 30.0;
  EXPECT_EQ(tracker_->track(covered, changed_elsewhere).state, TrackState::lost);
  const auto [back, error_m] = track(kAllButRound - 1, changed_elsewhere);
  EXPECT_EQ(back.state, TrackState::relocalised);
  EXPECT_LT(error_m, 0.009);
}

// In a small picture the box is nearly all that there is to see: the pose goes with it.
TEST_F(StaleModel, HoldsThePoseNoLongerOnceItIsMended) {
  start(test::small_camera());
  int index = 0;
  for (; index < kHalfWay; ++index) {
    const auto [tracked, error_m] = track(index, stale_);
    ASSERT_NE(tracked.state, TrackState::lost) << index;
    if (index + 1 < kHalfWay) continue;
    EXPECT_GT(error_m, 0.01);
    EXPECT_LT(error_m, 0.03);
  }
  const auto mended = model_of(moved_, false);
  for (const int end = index + 8; index < end; ++index) {
    const auto [tracked, error_now_m] = track(index, mended);
    ASSERT_NE(tracked.state, TrackState::lost) << index;
    EXPECT_LT(error_now_m, 0.003) << index;
  }
}

}  // namespace
}  // namespace meshloop
