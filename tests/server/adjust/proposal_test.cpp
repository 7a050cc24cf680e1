#include "server/adjust/proposal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "boxes.h"

namespace meshloop {
namespace {

using boxes::Box;
using boxes::make_world;

const Box kWall{{-2, -2, 2}, {2, 2, 2.1}, 1, true, 0.05};

// One box that came, and one that went.
std::unique_ptr<boxes::World> changed_world() {
  return make_world(
      {kWall, {{-0.4, -0.1, 1.6}, {-0.1, 0.1, 1.9}, 0, true}, {{0.1, -0.1, 1.7}, {0.4, 0.1, 1.9}, 2, false}},
      Pose::Identity());
}

TEST(Propose, OneProposalAConfirmedRegion) {
  const auto world = changed_world();
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 2u);
  for (const auto& proposal : proposals) {
    if (proposal.kind == ChangeKind::insertion) {
      EXPECT_EQ(std::get<AddNode>(proposal.edits.at(0)).node.id, 10u);
      EXPECT_THAT(proposal.effect,
                  testing::MatchesRegex("\\+[0-9]+ triangles; largest change 400 mm; closes region [0-9]+"));
      EXPECT_NEAR(proposal.largest_change_m, 0.4, 1e-3);
      EXPECT_GT(proposal.triangles_added, 0u);
    } else {
      EXPECT_THAT(proposal.effect, testing::MatchesRegex(
                                       "-[0-9]+ triangles(, \\+[0-9]+)?; largest change 300 mm; closes region [0-9]+"));
      EXPECT_GT(proposal.triangles_removed, 0u);
    }
    EXPECT_NE(proposal.id, 0u);
  }
}

TEST(Propose, AllAcceptedEditsApply) {
  const auto world = changed_world();
  const auto edits = merge_edits(world->model, propose(world->snapshot(), 10, {}));
  ASSERT_TRUE(edits.has_value());
  const auto changed = apply(world->model, edits->edits, 2);
  ASSERT_TRUE(changed.has_value());
  EXPECT_EQ(changed->nodes.size(), 3u);
}

TEST(Propose, NothingWhenThePoseIsLost) {
  const auto world = changed_world();
  auto snapshot = world->snapshot();
  snapshot.depth_pose.state = TrackState::lost;
  EXPECT_TRUE(propose(snapshot, 10, {}).empty());
  EXPECT_TRUE(insertion_patch(snapshot, 1, {}).triangles.empty());
  snapshot = world->snapshot();
  snapshot.depth_pose.T_camera_world.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(propose(snapshot, 10, {}).empty());
}

TEST(Propose, NothingFromAnIncompleteSnapshot) {
  EXPECT_TRUE(propose({}, 10, {}).empty());
  auto world = changed_world();
  world->frame.depth = DepthImage{160, 120, 1.0f};
  EXPECT_TRUE(propose(world->snapshot(), 10, {}).empty());
  EXPECT_TRUE(insertion_patch(world->snapshot(), 1, {}).triangles.empty());
}

TEST(Propose, SurvivesImagesThatContradictTheModel) {
  auto world = changed_world();
  for (auto& node : world->comparison.node_index.pixels()) node = 99;
  for (auto& z : world->frame.depth.pixels()) z = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(propose(world->snapshot(), 10, {}).empty());
}

TEST(Propose, UnknownRegionGivesNoPatch) {
  const auto world = changed_world();
  EXPECT_TRUE(insertion_patch(world->snapshot(), 999, {}).triangles.empty());
}

TEST(Propose, SaysWhenTheModelHadNothing) {
  Box unknown = kWall;
  unknown.node = 0;
  const auto world = make_world({unknown}, Pose::Identity());
  const auto proposals = propose(world->snapshot(), 1, {});
  ASSERT_EQ(proposals.size(), 1u);
  EXPECT_EQ(proposals[0].effect, "+152482 triangles, where the model had none; closes region 1");
}

TEST(MergeEdits, RefusesAProposalOfAnotherRevision) {
  const auto world = changed_world();
  const auto proposals = propose(world->snapshot(), 10, {});
  const auto edits = merge_edits(world->model, proposals);
  ASSERT_TRUE(edits.has_value());
  const auto changed = apply(world->model, edits->edits, 2);
  ASSERT_TRUE(changed.has_value());
  for (const auto& proposal : proposals) {
    const auto again = merge_edits(*changed, {proposal});
    ASSERT_FALSE(again.has_value());
    EXPECT_THAT(again.error().message, testing::HasSubstr("take a new snapshot"));
  }
}

TEST(MergeEdits, RefusesTheSameAdditionTwice) {
  const auto world = changed_world();
  auto proposals = propose(world->snapshot(), 10, {});
  std::erase_if(proposals, [](const Proposal& p) { return p.kind != ChangeKind::insertion; });
  ASSERT_EQ(proposals.size(), 1u);
  proposals.push_back(proposals[0]);
  EXPECT_FALSE(merge_edits(world->model, proposals).has_value());
}

TEST(MergeEdits, OfNothingIsNothing) {
  const auto edits = merge_edits(Model{}, {});
  ASSERT_TRUE(edits.has_value());
  EXPECT_TRUE(edits->edits.empty());
}

}  // namespace
}  // namespace meshloop
