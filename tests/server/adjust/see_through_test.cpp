// What speaks for a removal, and where a proposal is.
#include "server/adjust/see_through.h"

#include <gtest/gtest.h>

#include "boxes.h"

namespace meshloop {
namespace {

using boxes::Box;
using boxes::make_world;
using boxes::World;
using boxes::WorldOptions;

const Box kWall{{-2, -2, 2}, {2, 2, 2.1}, 1};

// A box in front of the wall, modelled as node 2, that is gone in reality.
Box gone_box(double edge_m = 0.01) {
  return {{-0.2, -0.15, 1.4}, {0.2, 0.15, 1.6}, 2, false, edge_m};
}

Proposal only_removal(const World& world) {
  auto proposals = propose(world.snapshot(), 10, {});
  std::erase_if(proposals, [](const Proposal& p) { return p.kind != ChangeKind::removal; });
  EXPECT_EQ(proposals.size(), 1u);
  return proposals.empty() ? Proposal{} : std::move(proposals[0]);
}

/// Pixels of the box's front at 1.4 m, in a camera that looks at it straight.
double front_pixels() {
  return (0.4 * 290 / 1.4) * (0.3 * 290 / 1.4);
}

TEST(SeeThrough, SaysHowMuchOfTheRemovedSurfaceInSightIsSeenThroughAndHowFar) {
  // In small triangles, which go whole, and in two a face, which are cut.
  for (const double edge_m : {0.01, 10.0}) {
    const auto world = make_world({kWall, gone_box(edge_m)}, Pose::Identity());
    const auto removal = only_removal(*world);
    ASSERT_TRUE(removal.see_through);
    EXPECT_NEAR(static_cast<double>(removal.see_through->visible), front_pixels(), 0.05 * front_pixels()) << edge_m;
    EXPECT_EQ(removal.see_through->measured, removal.see_through->visible);
    EXPECT_GT(removal.see_through->share(), 0.98) << edge_m;
    EXPECT_LE(removal.see_through->share(), 1);
    EXPECT_NEAR(removal.see_through->behind_m, 0.6, 0.002) << "the wall is at 2 m";
    EXPECT_NEAR(removal.see_through->behind_sigmas, 600, 2) << "the sensor's sigma is 1 mm";
    EXPECT_EQ(removal.confidence, removal.see_through->share());
  }
}

TEST(SeeThrough, CountsWhatWasNotMeasuredAsNotSeenThrough) {
  const auto world = make_world({kWall, gone_box()}, Pose::Identity());
  const auto removal = only_removal(*world);
  // The same removal, judged by a frame that has no depth in the upper half of the picture.
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 320; ++x) world->frame.depth(x, y) = 0;
  }
  const auto seen = adjust::look_through(world->snapshot(), removal.removed);
  EXPECT_EQ(seen.visible, removal.see_through->visible);
  EXPECT_NEAR(static_cast<double>(seen.measured) / static_cast<double>(seen.visible), 0.5, 0.02);
  EXPECT_EQ(seen.seen_through <= seen.measured, true);
  EXPECT_NEAR(seen.share(), 0.5, 0.03);
}

TEST(SeeThrough, IsNothingWhereTheSurfaceStands) {
  const auto world = make_world({kWall, gone_box()}, Pose::Identity());
  const Node& wall = *world->model.find(1);
  const Removal all{wall.id, wall.hash, std::vector<bool>(wall.submesh->triangles.size(), true), {}, wall.T_world_node};
  const auto seen = adjust::look_through(world->snapshot(), {all});
  EXPECT_GT(seen.visible, 10'000u);
  EXPECT_EQ(seen.seen_through, 0u);
  EXPECT_EQ(seen.share(), 0);
  EXPECT_EQ(seen.behind_m, 0);
  EXPECT_EQ(adjust::look_through(world->snapshot(), {}).share(), 0) << "nothing removed, nothing seen";
}

TEST(Place, IsAroundWhatComesAndWhatGoes) {
  const auto gone = make_world({kWall, gone_box()}, Pose::Identity());
  const auto removal = only_removal(*gone);
  EXPECT_TRUE(removal.box_m.min().isApprox(Eigen::Vector3d(-0.2, -0.15, 1.4), 1e-3)) << removal.box_m.min();
  EXPECT_NEAR(removal.box_m.max().x(), 0.2, 1e-3);
  EXPECT_NEAR(removal.box_m.max().y(), 0.15, 1e-3);
  EXPECT_EQ(removal.closes, std::vector<RegionId>{gone->region(ChangeKind::removal).id});

  const auto come = make_world({kWall, Box{{-0.2, -0.15, 1.4}, {0.2, 0.15, 1.6}, 0}}, Pose::Identity());
  come->regions.regions.at(0).significance = 3;
  const auto proposals = propose(come->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  EXPECT_TRUE(proposals[0].box_m.min().head<2>().isApprox(Eigen::Vector2d(-0.2, -0.15), 0.05));
  EXPECT_NEAR(proposals[0].box_m.min().z(), 1.4, 0.005);
  EXPECT_FALSE(proposals[0].see_through);
  EXPECT_NEAR(proposals[0].confidence, 0.9973, 1e-4) << "three sigma of a normal distribution";
}

}  // namespace
}  // namespace meshloop
