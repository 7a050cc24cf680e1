#include "server/compare/region_tracker.h"

#include <gtest/gtest.h>

#include <limits>

#include "compare_scene.h"
#include "server/compare/components.h"

namespace meshloop {
namespace {

using namespace compare_test;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr float kWall_m = 2;

struct Rectangle {
  int u;
  int v;
  int width;
  int height;
};

// A wall at two metres that fills the picture, and pixels painted over it.
class RegionTrackerTest : public testing::Test {
 protected:
  RegionTrackerTest() { clear(); }
  void clear() {
    comparison_ = {Image<Label>(kWidth, kHeight, Label::agrees), Image<float>(kWidth, kHeight, 0.0F),
                   DepthImage(kWidth, kHeight, kWall_m), Image<std::uint32_t>(kWidth, kHeight, 1U),
                   Image<float>(kWidth, kHeight, 0.03F)};
    measured_ = DepthImage(kWidth, kHeight, kWall_m);
  }
  void paint(const Rectangle& area, Label label, float difference_m) {
    for (int v = area.v; v < area.v + area.height; ++v) {
      for (int u = area.u; u < area.u + area.width; ++u) {
        comparison_.labels(u, v) = label;
        measured_(u, v) = kWall_m + difference_m;
        comparison_.difference_m(u, v) = difference_m;
        if (label != Label::unmodelled) continue;
        comparison_.expected(u, v) = 0;
        comparison_.difference_m(u, v) = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  RegionMap update() { return tracker_.update(comparison_, measured_, camera_, T_camera_world_); }

  Comparison comparison_;
  DepthImage measured_;
  Camera camera_ = camera_of(kWidth, kHeight);
  Pose T_camera_world_ = at(0.3, -0.2, 0.1, 0.4);
  RegionTracker tracker_{RegionOptions{}};
};

TEST_F(RegionTrackerTest, NothingChangedGivesNoRegions) {
  const auto map = update();
  EXPECT_TRUE(map.regions.empty());
  for (const auto id : map.ids.pixels()) ASSERT_EQ(id, 0U);
}

TEST_F(RegionTrackerTest, RegionIsMeasured) {
  paint({100, 200, 40, 30}, Label::closer, -0.5F);
  measured_(110, 210) = 1.25F;
  comparison_.difference_m(110, 210) = -0.75F;
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 1U);
  const Region& region = map.regions.front();
  EXPECT_EQ(region.id, 1U);
  EXPECT_EQ(region.kind, ChangeKind::insertion);
  EXPECT_EQ(region.pixels, 1200);
  EXPECT_NEAR(region.area_m2, 1200 * 1.5 * 1.5 / (camera_.fx * camera_.fy), 1e-5);
  EXPECT_NEAR(region.mean_difference_m, -0.5 - 0.25 / 1200, 1e-6);
  EXPECT_NEAR(region.max_difference_m, -0.75, 1e-6);
  EXPECT_NEAR(region.significance, 50, 0.1);
  EXPECT_EQ(region.pixel_box.min(), Eigen::Vector2i(100, 200));
  EXPECT_EQ(region.pixel_box.max(), Eigen::Vector2i(139, 229));
  EXPECT_EQ(region.frames_seen, 1);
  EXPECT_FALSE(region.confirmed);
  const Eigen::Vector3d p = T_camera_world_.inverse() * camera_.back_project(120, 215, 1.5);
  EXPECT_TRUE(region.world_box.contains(p));
  EXPECT_LT(region.world_box.diagonal().norm(), 0.8);
}

TEST_F(RegionTrackerTest, RemovedThingLiesWhereItWasExpected) {
  paint({100, 200, 40, 30}, Label::farther, 1.0F);
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 1U);
  const Region& region = map.regions.front();
  EXPECT_EQ(region.kind, ChangeKind::removal);
  EXPECT_NEAR(region.area_m2, 1200 * 2.0 * 2.0 / (camera_.fx * camera_.fy), 1e-5);
  EXPECT_TRUE(region.world_box.contains(T_camera_world_.inverse() * camera_.back_project(120, 215, 2)));
  EXPECT_FALSE(region.world_box.contains(T_camera_world_.inverse() * camera_.back_project(120, 215, 3)));
}

TEST_F(RegionTrackerTest, UnmodelledHasNoDifferenceAndAFixedSignificance) {
  paint({100, 200, 40, 30}, Label::unmodelled, 0.5F);
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 1U);
  EXPECT_EQ(map.regions.front().mean_difference_m, 0);
  EXPECT_EQ(map.regions.front().max_difference_m, 0);
  EXPECT_NEAR(map.regions.front().significance, 10, 1e-9);
}

TEST_F(RegionTrackerTest, CloserAndUnmodelledAreOneInsertion) {
  paint({100, 200, 20, 30}, Label::closer, -0.5F);
  paint({120, 200, 20, 30}, Label::unmodelled, -0.5F);
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 1U);
  EXPECT_EQ(map.regions.front().pixels, 1200);
  EXPECT_NEAR(map.regions.front().mean_difference_m, -0.5, 1e-6);
}

TEST_F(RegionTrackerTest, InsertionAndRemovalSideBySideAreTwo) {
  paint({100, 200, 20, 30}, Label::closer, -0.5F);
  paint({120, 200, 20, 30}, Label::farther, 0.5F);
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 2U);
  EXPECT_NE(map.ids(119, 210), map.ids(120, 210));
}

TEST_F(RegionTrackerTest, GapOfOnePixelIsClosedAndOfTwoIsNot) {
  paint({100, 200, 40, 30}, Label::closer, -0.5F);
  paint({120, 200, 1, 30}, Label::agrees, 0);
  EXPECT_EQ(update().regions.size(), 1U);
  EXPECT_EQ(update().ids(120, 210), 0U);
  paint({120, 200, 2, 30}, Label::agrees, 0);
  EXPECT_EQ(update().regions.size(), 2U);
}

TEST_F(RegionTrackerTest, ThinChangeIsKept) {
  paint({100, 200, 200, 1}, Label::closer, -0.5F);
  EXPECT_EQ(update().regions.size(), 1U);
}

TEST_F(RegionTrackerTest, SpecksAreDropped) {
  paint({100, 200, 7, 8}, Label::closer, -0.5F);
  EXPECT_TRUE(update().regions.empty());
  paint({100, 200, 8, 8}, Label::closer, -0.5F);
  EXPECT_EQ(update().regions.size(), 1U);
}

TEST_F(RegionTrackerTest, ManyPixelsOfATinyAreaAreDropped) {
  paint({100, 200, 8, 8}, Label::closer, -1.9F);
  EXPECT_TRUE(update().regions.empty());
}

TEST_F(RegionTrackerTest, LeastSizeFollowsTheImagesArea) {
  camera_ = camera_of(kWidth / 2, kHeight / 2);
  comparison_ = {Image<Label>(kWidth / 2, kHeight / 2, Label::agrees), Image<float>(kWidth / 2, kHeight / 2, 0.0F),
                 DepthImage(kWidth / 2, kHeight / 2, kWall_m), Image<std::uint32_t>(kWidth / 2, kHeight / 2, 1U),
                 Image<float>(kWidth / 2, kHeight / 2, 0.03F)};
  measured_ = DepthImage(kWidth / 2, kHeight / 2, kWall_m);
  paint({50, 60, 4, 4}, Label::closer, -0.5F);
  EXPECT_EQ(update().regions.size(), 1U);
}

TEST_F(RegionTrackerTest, KeepsItsIdWhileTheCameraMovesAndIsConfirmed) {
  // A box before the wall, seen by a camera that goes sideways.
  for (int frame = 0; frame < 5; ++frame) {
    clear();
    const int shift = 9 * frame;
    T_camera_world_ = at(shift * 1.5 / camera_.fx, 0, 0);
    paint({200 + shift, 200, 60, 50}, Label::closer, -0.5F);
    paint({400 + shift, 200, 60, 50}, Label::closer, -0.5F);
    const auto map = update();
    ASSERT_EQ(map.regions.size(), 2U);
    EXPECT_EQ(map.ids(220 + shift, 220), 1U);
    EXPECT_EQ(map.ids(420 + shift, 220), 2U);
    EXPECT_EQ(map.regions[0].frames_seen, frame + 1);
    EXPECT_EQ(map.regions[0].views_seen, frame + 1);
    EXPECT_EQ(map.regions[0].confirmed, frame >= 2);
  }
}

// Four sigma, where the threshold is three.
constexpr float kWeak_m = -0.04F;

TEST_F(RegionTrackerTest, RestingCameraConfirmsWhatIsStrongAtOnce) {
  paint({200, 200, 60, 50}, Label::closer, -0.07F);
  for (int frame = 1; frame <= 4; ++frame) EXPECT_EQ(update().regions[0].confirmed, frame >= 3) << frame;
}

TEST_F(RegionTrackerTest, RestingCameraConfirmsLater) {
  paint({200, 200, 60, 50}, Label::closer, kWeak_m);
  for (int frame = 1; frame <= 12; ++frame) {
    const auto map = update();
    ASSERT_EQ(map.regions.size(), 1U);
    EXPECT_EQ(map.regions[0].views_seen, 1);
    EXPECT_EQ(map.regions[0].confirmed, frame >= 8) << frame;
  }
}

TEST_F(RegionTrackerTest, ViewsBeforeARestCount) {
  for (int frame = 0; frame < 10; ++frame) {
    clear();
    const int shift = frame == 0 ? 0 : 12;
    T_camera_world_ = at(shift * static_cast<double>(kWall_m + kWeak_m) / camera_.fx, 0, 0);
    paint({200 + shift, 200, 60, 50}, Label::closer, kWeak_m);
    const auto map = update();
    EXPECT_EQ(map.regions[0].views_seen, frame == 0 ? 1 : 2);
    EXPECT_EQ(map.regions[0].confirmed, frame >= 8) << frame;
  }
}

TEST_F(RegionTrackerTest, NoiseThatSticksToTheCamerasPixelsIsNotConfirmedByMotion) {
  // The camera goes sideways or turns; the region stays in the picture.
  for (const bool turns : {false, true}) {
    tracker_.reset();
    paint({200, 200, 30, 25}, Label::closer, kWeak_m);
    int longest = 0;
    for (int frame = 0; frame < 100; ++frame) {
      const double step = 4.0 * frame / camera_.fx;
      T_camera_world_ = turns ? Pose{Eigen::AngleAxisd{step, Eigen::Vector3d::UnitY()}} : at(1.9 * step, 0, 0);
      const auto map = update();
      ASSERT_EQ(map.regions.size(), 1U);
      longest = std::max(longest, map.regions[0].frames_seen);
      ASSERT_FALSE(map.regions[0].confirmed) << "turns " << turns << ", frame " << frame;
    }
    // It was taken for the same region long enough to be confirmed, had it counted frames.
    EXPECT_GT(longest, 8);
  }
}

TEST_F(RegionTrackerTest, ConfirmedRegionComesBackUnderItsId) {
  paint({200, 200, 60, 50}, Label::closer, -0.5F);
  for (int i = 0; i < 8; ++i) update();
  clear();
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(update().regions.empty());
  paint({200, 200, 60, 50}, Label::closer, -0.5F);
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 1U);
  EXPECT_EQ(map.regions.front().id, 1U);
  EXPECT_TRUE(map.regions.front().confirmed);
}

TEST_F(RegionTrackerTest, UnconfirmedRegionIsForgotten) {
  paint({200, 200, 60, 50}, Label::closer, -0.5F);
  update();
  clear();
  for (int i = 0; i < 6; ++i) update();
  paint({200, 200, 60, 50}, Label::closer, -0.5F);
  EXPECT_EQ(update().regions.front().id, 2U);
}

TEST_F(RegionTrackerTest, OtherKindAtTheSamePlaceIsAnotherRegion) {
  paint({200, 200, 60, 50}, Label::closer, -0.1F);
  update();
  paint({200, 200, 60, 50}, Label::farther, 0.1F);
  EXPECT_EQ(update().regions.front().id, 2U);
}

TEST_F(RegionTrackerTest, RegionThatFallsApartKeepsItsIdOnce) {
  paint({200, 200, 100, 50}, Label::closer, -0.5F);
  update();
  paint({270, 200, 5, 50}, Label::agrees, 0);
  const auto map = update();
  ASSERT_EQ(map.regions.size(), 2U);
  EXPECT_EQ(map.ids(210, 210), 1U);
  EXPECT_EQ(map.ids(290, 210), 2U);
}

TEST_F(RegionTrackerTest, ResetNeverGivesAnIdAgain) {
  paint({200, 200, 60, 50}, Label::closer, -0.5F);
  update();
  tracker_.reset();
  const auto map = update();
  EXPECT_EQ(map.regions.front().id, 2U);
  EXPECT_EQ(map.regions.front().frames_seen, 1);
}

TEST_F(RegionTrackerTest, ImagesOfOtherSizesGiveAnEmptyMap) {
  measured_ = DepthImage(16, 16, 1.0F);
  EXPECT_TRUE(update().regions.empty());
}

TEST(ConnectChanges, JoinsBranchesThatMeetLate) {
  // A fork that opens upwards: two sets in the first rows, one in the end.
  Image<Label> labels(9, 9, Label::agrees);
  for (int v = 0; v < 8; ++v) {
    labels(0, v) = Label::farther;
    labels(8, v) = Label::farther;
  }
  for (int u = 0; u < 9; ++u) labels(u, 8) = Label::farther;
  const auto components = connect_changes(labels);
  EXPECT_EQ(components.count, 1U);
  EXPECT_EQ(components.numbers(0, 0), components.numbers(8, 0));
  EXPECT_EQ(components.numbers(4, 4), 0U);
}

TEST(ConnectChanges, EmptyImageHasNone) {
  EXPECT_EQ(connect_changes(Image<Label>{}).count, 0U);
}

}  // namespace
}  // namespace meshloop
