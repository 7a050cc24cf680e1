#include "server/pipeline/recent_depths.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

TrackedFrame frame(int index) {
  TrackedFrame tracked;
  tracked.frame.index = index;
  tracked.frame.depth = DepthImage{2, 2, static_cast<float>(index)};
  tracked.depth_pose.T_camera_world.translation().x() = index;
  return tracked;
}

TEST(RecentDepths, GivesTheNewestBeforeAFrame) {
  RecentDepths recent{3};
  for (int i = 0; i < 6; ++i) recent.add(frame(i));
  const auto views = recent.before(frame(5), 0);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ((*views[0].depth)(0, 0), 4);
  EXPECT_EQ(views[0].T_camera_world.translation().x(), 4);
  EXPECT_EQ((*views[1].depth)(0, 0), 3);
}

TEST(RecentDepths, LeavesOutWhatIsTooOld) {
  RecentDepths recent{8};
  for (int i = 0; i < 6; ++i) recent.add(frame(i));
  EXPECT_EQ(recent.before(frame(5), 4).size(), 1u);
  EXPECT_TRUE(recent.before(frame(5), 5).empty());
}

TEST(RecentDepths, GivesNothingOfFramesThatWereWithheld) {
  RecentDepths recent{8};
  for (int i = 0; i < 4; ++i) recent.add(frame(i));
  recent.drop(2);
  recent.drop(7);
  const auto views = recent.before(frame(4), 0);
  ASSERT_EQ(views.size(), 3u);
  EXPECT_EQ((*views[0].depth)(0, 0), 3);
  EXPECT_EQ((*views[1].depth)(0, 0), 1);
  const RecentDepths earlier = recent;
  recent.clear();
  recent.add(frame(4));
  EXPECT_EQ(recent.before(frame(5), 0).size(), 1u);
  EXPECT_EQ(earlier.before(frame(4), 0).size(), 3u) << "what an offer was made of";
}

TEST(RecentDepths, OfOneFrameNothingIsKept) {
  RecentDepths recent{1};
  recent.add(frame(0));
  EXPECT_TRUE(recent.before(frame(1), 0).empty());
}

TEST(FirstFrame, IsThatOfTheYoungestRegionThatAsksForSurface) {
  RegionMap map;
  const auto add = [&](ChangeKind kind, bool confirmed, int frames_seen) {
    Region region;
    region.kind = kind;
    region.confirmed = confirmed;
    region.frames_seen = frames_seen;
    map.regions.push_back(region);
  };
  add(ChangeKind::insertion, true, 5);
  add(ChangeKind::insertion, true, 3);
  add(ChangeKind::insertion, false, 1);
  add(ChangeKind::removal, true, 2);
  EXPECT_EQ(first_frame_of(map, 20), 18);
}

}  // namespace
}  // namespace meshloop
