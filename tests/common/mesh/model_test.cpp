#include "common/mesh/model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace meshloop {
namespace {

using testing::HasSubstr;

Submesh triangle(float size) {
  return {{{0, 0, 0}, {size, 0, 0}, {0, size, 0}}, {}, {{0, 1, 2}}};
}

Model two_nodes() {
  return apply({}, {AddNode{make_node(5, "box", triangle(1))}, AddNode{make_node(2, "wall", triangle(2))}}, 1).value();
}

TEST(Model, KeepsNodesInTheOrderOfTheirIds) {
  const Model model = two_nodes();
  EXPECT_EQ(model.revision, 1u);
  ASSERT_EQ(model.nodes.size(), 2u);
  EXPECT_EQ(model.nodes[0].name, "wall");
  EXPECT_EQ(model.find(5)->name, "box");
  EXPECT_EQ(model.find(3), nullptr);
  EXPECT_EQ(model.triangle_count(), 2u);
}

TEST(Model, AnEditLeavesTheOldModelAndSharesWhatItDoesNotName) {
  const Model old = two_nodes();
  const auto replacement = std::make_shared<const Submesh>(triangle(3));
  const Model changed = apply(old, {ReplaceSubmesh{2, replacement}}, 7).value();
  EXPECT_EQ(changed.revision, 7u);
  EXPECT_EQ(changed.find(2)->submesh, replacement);
  EXPECT_EQ(changed.find(2)->hash, content_hash(*replacement));
  EXPECT_EQ(changed.find(5)->submesh, old.find(5)->submesh);
  EXPECT_EQ(old.find(2)->hash, content_hash(triangle(2)));
  EXPECT_EQ(old.revision, 1u);
}

TEST(Model, MovesAndRemovesNodes) {
  const Pose T = make_pose({1, 2, 3}, Eigen::Quaterniond::Identity());
  const Model changed = apply(two_nodes(), {MoveNode{5, T}, RemoveNode{2}}, 2).value();
  ASSERT_EQ(changed.nodes.size(), 1u);
  EXPECT_EQ(changed.nodes[0].T_world_node.translation(), T.translation());
}

TEST(Model, AppliesEditsInTheirOrder) {
  const auto moved = apply(two_nodes(), {RemoveNode{2}, AddNode{make_node(2, "new wall", triangle(4))}}, 2);
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->find(2)->name, "new wall");
  EXPECT_FALSE(apply(two_nodes(), {RemoveNode{2}, MoveNode{2, Pose::Identity()}}, 2));
}

TEST(Model, RefusesIdsThatAreUnknownOrUsed) {
  EXPECT_THAT(apply(two_nodes(), {RemoveNode{9}}, 2).error().message, HasSubstr("no node 9"));
  EXPECT_FALSE(apply(two_nodes(), {MoveNode{9, Pose::Identity()}}, 2));
  EXPECT_FALSE(apply(two_nodes(), {ReplaceSubmesh{9, std::make_shared<const Submesh>(triangle(1))}}, 2));
  EXPECT_THAT(apply(two_nodes(), {AddNode{make_node(5, "again", triangle(1))}}, 2).error().message,
              HasSubstr("node 5 already"));
  EXPECT_FALSE(apply(two_nodes(), {AddNode{make_node(0, "zero", triangle(1))}}, 2));
}

TEST(Model, RefusesGeometryAndPosesThatAreNotValid) {
  EXPECT_FALSE(apply(two_nodes(), {AddNode{make_node(7, "empty", {})}}, 2));
  EXPECT_FALSE(apply(two_nodes(), {AddNode{}}, 2));
  EXPECT_FALSE(apply(two_nodes(), {ReplaceSubmesh{5, nullptr}}, 2));
  EXPECT_FALSE(apply(two_nodes(), {ReplaceSubmesh{5, std::make_shared<const Submesh>()}}, 2));
  Pose scaled = Pose::Identity();
  scaled.linear() *= 2;
  EXPECT_THAT(apply(two_nodes(), {MoveNode{5, scaled}}, 2).error().message, HasSubstr("not rigid"));
}

}  // namespace
}  // namespace meshloop
