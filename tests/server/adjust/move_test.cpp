// Things that moved, told apart from things that came and went.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "common/mesh/lattice.h"
#include "moved_things.h"

namespace meshloop {
namespace {

using moved_things::box_on_table;
using moved_things::camera_at;
using moved_things::can_on_table;
using moved_things::look;
using moved_things::table;
using moved_things::View;
using simulation::Scene;
using simulation::Solid;

constexpr unsigned kCases = 24;
constexpr double kDegree = std::numbers::pi / 180;

/// A box on the table, and a camera before it.
struct Case {
  Scene table_before;
  Solid box;
  View view;
  /// From the camera to the box, metres.
  double distance_m = 0;
};

/// Random numbers of one case.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_{seed} {}
  double operator()(double low, double high) { return std::uniform_real_distribution<double>{low, high}(random_); }

 private:
  std::mt19937 random_;
};

Case make_case(unsigned seed, Draw& draw) {
  Case made;
  const bool has_print = seed % 2 == 0;
  made.table_before = table(seed % 4 < 2);
  const Eigen::Vector3d size{draw(0.14, 0.28), draw(0.1, 0.2), draw(0.08, 0.18)};
  made.box = box_on_table(size, draw(-0.06, 0.06), draw(-0.06, 0.06), draw(0, 180), has_print, seed);
  made.view.T_world_depth = camera_at(draw(0.85, 1.45), draw(-50, 50), draw(25, 50));
  made.view.seed = seed + 100;
  made.distance_m = (made.view.T_world_depth.translation() - made.box.T_world_solid.translation()).norm();
  return made;
}

Scene with(const Scene& scene, const Solid& solid) {
  Scene both = scene;
  both.solids.push_back(solid);
  return both;
}

Solid moved(Solid solid, const Pose& motion) {
  const Eigen::Vector3d center = solid.T_world_solid.translation();
  solid.T_world_solid.linear() = motion.linear() * solid.T_world_solid.linear();
  solid.T_world_solid.translation() = center + motion.translation();
  return solid;
}

/// Along the table, and turned about the vertical.
Pose motion(double way_m, double towards_degrees, double turn_degrees) {
  return make_pose({way_m * std::cos(towards_degrees * kDegree), way_m * std::sin(towards_degrees * kDegree), 0},
                   Eigen::Quaterniond{Eigen::AngleAxisd{turn_degrees * kDegree, Eigen::Vector3d::UnitZ()}});
}

struct Error {
  /// Of the box's middle.
  double mm = 0;
  double degrees = 0;
};

Error error_of(const Move& move, const Solid& before, const Solid& after) {
  const Pose truth = after.T_world_solid * before.T_world_solid.inverse();
  const Eigen::Vector3d center = before.T_world_solid.translation();
  const Pose off = truth.inverse() * move.T_world_new_old;
  return {1000 * (truth * center - move.T_world_new_old * center).norm(),
          Eigen::AngleAxisd{off.linear()}.angle() / kDegree};
}

std::vector<Proposal> moves_of(const std::vector<Proposal>& proposals) {
  std::vector<Proposal> moves;
  std::copy_if(proposals.begin(), proposals.end(), std::back_inserter(moves),
               [](const Proposal& proposal) { return proposal.move.has_value(); });
  return moves;
}

/// How many of kCases were told, and the largest errors as if seen from 1 m (noise grows with the distance squared).
struct Figures {
  int told = 0;
  double worst_mm = 0;
  double worst_degrees = 0;
  double mean_mm = 0;
};

Figures move_all(double way_m, double turn_degrees) {
  Figures figures;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    Draw draw{seed};
    const Case one = make_case(seed, draw);
    const double side = seed % 3 == 0 ? -1 : 1;
    const Solid after = moved(one.box, motion(way_m, draw(0, 360), side * turn_degrees));
    const auto world = look(with(one.table_before, one.box), with(one.table_before, after), one.view);
    const auto proposals = propose(world->snapshot(), 50, {});
    const auto moves = moves_of(proposals);
    EXPECT_EQ(moves.size(), 1U) << "case " << seed;
    if (moves.size() != 1) continue;
    const Error error = error_of(*moves[0].move, one.box, after);
    const double scale = std::max(1.0, one.distance_m * one.distance_m);
    ++figures.told;
    figures.worst_mm = std::max(figures.worst_mm, error.mm / scale);
    figures.worst_degrees = std::max(figures.worst_degrees, error.degrees / scale);
    figures.mean_mm += error.mm / scale / kCases;
  }
  std::printf("%d of %u; at worst %.2f mm and %.2f degrees at 1 m, %.2f mm on average\n", figures.told, kCases,
              figures.worst_mm, figures.worst_degrees, figures.mean_mm);
  return figures;
}

TEST(Moves, ABoxThatMovedTwoCentimetres) {
  const Figures figures = move_all(0.02, 0);
  EXPECT_EQ(figures.told, static_cast<int>(kCases));
  EXPECT_LT(figures.worst_mm, 3);
  EXPECT_LT(figures.worst_degrees, 0.5);
}

TEST(Moves, ABoxThatMovedTwelveCentimetresAndTurned) {
  const Figures figures = move_all(0.12, 30);
  EXPECT_EQ(figures.told, static_cast<int>(kCases));
  EXPECT_LT(figures.worst_mm, 3);
  EXPECT_LT(figures.worst_degrees, 0.5);
}

/// Another thing: a box of which one side at least differs by 3 cm, or a can.
Solid other_thing(const Solid& box, unsigned seed, Draw& draw) {
  const double x = box.T_world_solid.translation().x() + draw(-0.03, 0.03);
  const double y = box.T_world_solid.translation().y() + draw(-0.03, 0.03);
  if (seed % 4 == 3) return can_on_table(draw(0.08, 0.16), draw(0.08, 0.2), x, y);
  Eigen::Vector3d size = box.size;
  const auto side = static_cast<Eigen::Index>(seed % 3);
  size[side] += (seed % 2 == 0 ? 1 : -1) * draw(0.03, 0.05);
  return box_on_table(size, x, y, draw(0, 180), seed % 2 == 0, seed + 500);
}

TEST(Moves, ABoxThatWasSwappedForAnotherThingIsNone) {
  int told = 0;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    Draw draw{seed};
    const Case one = make_case(seed, draw);
    const auto world =
        look(with(one.table_before, one.box), with(one.table_before, other_thing(one.box, seed, draw)), one.view);
    const auto proposals = propose(world->snapshot(), 50, {});
    EXPECT_FALSE(proposals.empty()) << seed;
    const auto moves = moves_of(proposals);
    EXPECT_TRUE(moves.empty()) << "case " << seed << ": " << moves[0].effect;
    if (moves.empty()) ++told;
  }
  std::printf("%d of %u\n", told, kCases);
  EXPECT_EQ(told, static_cast<int>(kCases));
}

/// A box of one colour, 22 x 15 x 12 cm, seen from 1.1 m.
const Eigen::Vector3d kSize{0.22, 0.15, 0.12};
const View kView{camera_at(1.1, 20, 35), 1, 1};

std::vector<Proposal> seen_after(const Scene& before, const Scene& after, const AdjustOptions& options = {}) {
  return propose(look(before, after, kView)->snapshot(), 50, options);
}

TEST(Moves, NothingMovedAndNothingIsProposed) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    Draw draw{seed};
    const Case one = make_case(seed, draw);
    const Scene scene = with(one.table_before, one.box);
    EXPECT_TRUE(propose(look(scene, scene, one.view)->snapshot(), 50, {}).empty()) << seed;
  }
}

TEST(Moves, AWholeNodeGetsAnotherPoseAndKeepsItsTriangles) {
  const Solid box = box_on_table(kSize, 0, 0, 20, false, 1);
  const auto world = look(with(table(false), box), with(table(false), moved(box, motion(0.12, 40, 30))), kView);
  const auto proposals = propose(world->snapshot(), 50, {});
  ASSERT_EQ(proposals.size(), 1U);
  const Proposal& proposal = proposals[0];
  ASSERT_TRUE(proposal.move);
  EXPECT_EQ(proposal.kind, ChangeKind::none);
  EXPECT_EQ(proposal.id, proposal.move->closes.front());
  EXPECT_EQ(proposal.move->closes.size(), world->regions.regions.size());
  EXPECT_THAT(proposal.effect, testing::StartsWith("moves \"box\" by 120 mm and 30 degrees; closes regions "));
  const NodeId id = proposal.move->node;
  EXPECT_EQ(proposal.move->new_node, 0U);
  const auto merged = merge_edits(world->model, proposals);
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_EQ(merged->triangles_added + merged->triangles_removed, 0U);
  const auto changed = apply(world->model, merged->edits, 2);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->find(id)->submesh, world->model.find(id)->submesh);
  const Pose expected = proposal.move->T_world_new_old * world->model.find(id)->T_world_node;
  EXPECT_TRUE(changed->find(id)->T_world_node.isApprox(expected, 1e-9));
  // Made for the model as it was.
  EXPECT_FALSE(merge_edits(*changed, proposals));
}

/// What of a node faces away from the camera becomes node 40, as if another snapshot had made it.
void split_off_back(moved_things::World& world, NodeId id) {
  const auto node = std::find_if(world.model.nodes.begin(), world.model.nodes.end(),
                                 [&](const Node& other) { return other.id == id; });
  const Submesh whole = *node->submesh;
  const Pose T_camera_node = world.T_depth_world * node->T_world_node;
  std::vector<bool> faces_camera;
  for (const auto& [a, b, c] : whole.triangles) {
    const Eigen::Vector3d p = T_camera_node * whole.positions[a].cast<double>();
    const Eigen::Vector3d q = T_camera_node * whole.positions[b].cast<double>();
    const Eigen::Vector3d r = T_camera_node * whole.positions[c].cast<double>();
    faces_camera.push_back((q - p).cross(r - p).dot(p) < 0);
  }
  const Pose T_world_node = node->T_world_node;
  *node = make_node(id, node->name, keep_triangles(whole, faces_camera), T_world_node);
  faces_camera.flip();
  world.model.nodes.push_back(make_node(40, "back", keep_triangles(whole, faces_camera), T_world_node));
}

TEST(Moves, TheBackThatIsNotSeenMovesAlong) {
  const Solid box = box_on_table(kSize, 0, 0, 20, false, 1);
  const Solid after = moved(box, motion(0.06, 40, 0));
  auto world = look(with(table(false), box), with(table(false), after), kView);
  const NodeId id = moves_of(propose(world->snapshot(), 50, {})).at(0).move->node;
  split_off_back(*world, id);
  const auto proposals = propose(world->snapshot(), 50, {});
  ASSERT_EQ(proposals.size(), 1U);
  const Move& move = *proposals[0].move;
  EXPECT_EQ(move.node, id);
  ASSERT_EQ(move.along.size(), 1U);
  EXPECT_EQ(move.along[0].node, 40U);
  EXPECT_THAT(proposals[0].effect, testing::StartsWith("moves \"box\" and 1 more node by 60 mm and 0 degrees"));
  const auto merged = merge_edits(world->model, proposals);
  ASSERT_TRUE(merged) << merged.error().message;
  const auto changed = apply(world->model, merged->edits, 2);
  ASSERT_TRUE(changed);
  EXPECT_TRUE(changed->find(40)->T_world_node.isApprox(changed->find(id)->T_world_node, 1e-9));
  EXPECT_EQ(changed->find(40)->submesh, world->model.find(40)->submesh);
  // Made for the model as it was.
  EXPECT_FALSE(merge_edits(*changed, proposals));
}

// It stands within the box around the arch, and is seen where it was.
TEST(Moves, WhatIsSeenToStayDoesNotMoveAlong) {
  Scene before = table(false);
  const auto leg = [](double x) { return box_on_table({0.05, 0.12, 0.22}, x, 0, 0, false, 1); };
  Solid beam = box_on_table({0.35, 0.12, 0.05}, 0, 0, 0, false, 1);
  beam.T_world_solid.translation().z() += 0.22;
  Scene after = before;
  for (Solid part : {leg(-0.15), leg(0.15), beam}) {
    part.object = "arch";
    before.solids.push_back(part);
    after.solids.push_back(moved(part, motion(0.04, 0, 0)));
  }
  const Solid can = can_on_table(0.06, 0.12, 0, 0);
  before.solids.push_back(can);
  after.solids.push_back(can);
  const auto moves = moves_of(seen_after(before, after));
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_THAT(moves[0].effect, testing::StartsWith("moves \"arch\" by 40 mm"));
  EXPECT_TRUE(moves[0].move->along.empty());
}

TEST(Moves, APartOfANodeBecomesANodeOfItsOwn) {
  Solid box = box_on_table(kSize, 0, 0, 20, true, 1);
  box.object = "table";
  const auto world = look(with(table(true), box), with(table(true), moved(box, motion(0.12, 40, 30))), kView);
  const auto proposals = propose(world->snapshot(), 50, {});
  const auto moves = moves_of(proposals);
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_LT(error_of(*moves[0].move, box, moved(box, motion(0.12, 40, 30))).mm, 3);
  const NodeId old_id = moves[0].move->node;
  EXPECT_EQ(moves[0].move->new_node, 50U);
  EXPECT_THAT(moves[0].effect, testing::StartsWith("moves a part of \"table\" by"));
  const auto merged = merge_edits(world->model, proposals);
  ASSERT_TRUE(merged) << merged.error().message;
  const auto changed = apply(world->model, merged->edits, 2);
  ASSERT_TRUE(changed);
  const Submesh& before = *world->model.find(old_id)->submesh;
  const Submesh& rest = *changed->find(old_id)->submesh;
  const Submesh& part = *changed->find(50)->submesh;
  EXPECT_EQ(rest.triangles.size() + part.triangles.size(), before.triangles.size());
  std::vector<bool> stays = moves[0].move->triangles;
  EXPECT_EQ(content_hash(part), content_hash(keep_triangles(before, stays)));
  stays.flip();
  EXPECT_EQ(content_hash(rest), content_hash(keep_triangles(before, stays)));
  EXPECT_TRUE(is_on_lattice(part));
  EXPECT_TRUE(part.has_colors());
}

TEST(Moves, APartMovesAndAnotherGoes) {
  Solid box = box_on_table(kSize, 0.05, 0, 20, false, 1);
  Solid gone = box_on_table({0.1, 0.1, 0.1}, -0.4, -0.1, 20, false, 2);
  box.object = gone.object = "table";
  const auto world =
      look(with(with(table(false), box), gone), with(table(false), moved(box, motion(0.12, 40, 30))), kView);
  const auto proposals = propose(world->snapshot(), 50, {});
  ASSERT_EQ(proposals.size(), 2U);
  ASSERT_TRUE(proposals[0].move);
  ASSERT_EQ(proposals[1].kind, ChangeKind::removal);
  const auto merged = merge_edits(world->model, proposals);
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_EQ(merged->triangles_added, 0U);
  EXPECT_EQ(merged->triangles_removed, proposals[1].triangles_removed);
  const auto changed = apply(world->model, merged->edits, 2);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->triangle_count(), world->model.triangle_count() - proposals[1].triangles_removed);
}

TEST(Moves, WithoutTheSearchItIsRemovedAndInserted) {
  const Solid box = box_on_table(kSize, 0, 0, 20, false, 1);
  const auto proposals =
      seen_after(with(table(false), box), with(table(false), moved(box, motion(0.12, 40, 30))), {.moves = false});
  EXPECT_TRUE(moves_of(proposals).empty());
  EXPECT_GE(proposals.size(), 2U);
}

TEST(Moves, WhatElseCameIsInserted) {
  const Solid box = box_on_table(kSize, 0, 0, 20, false, 1);
  Scene after = with(table(false), moved(box, motion(0.12, 40, 30)));
  after.solids.push_back(can_on_table(0.09, 0.14, -0.35, -0.1));
  const auto world = look(with(table(false), box), after, kView);
  const auto proposals = propose(world->snapshot(), 50, {});
  EXPECT_EQ(moves_of(proposals).size(), 1U);
  ASSERT_EQ(proposals.size(), 2U);
  EXPECT_EQ(proposals[1].kind, ChangeKind::insertion);
  const auto merged = merge_edits(world->model, proposals);
  ASSERT_TRUE(merged) << merged.error().message;
  EXPECT_TRUE(apply(world->model, merged->edits, 2));
}

// A quarter and 30 degrees more, as print tells; without print the shorter turn looks the same.
TEST(Moves, ACubeTurnsAsItsPrintSays) {
  for (const bool has_print : {true, false}) {
    const Solid cube = box_on_table({0.16, 0.16, 0.16}, 0, 0, 10, has_print, 3);
    const Solid after = moved(cube, motion(0.12, 40, 120));
    const auto moves = moves_of(seen_after(with(table(false), cube), with(table(false), after)));
    ASSERT_EQ(moves.size(), 1U) << has_print;
    const Error error = error_of(*moves[0].move, cube, after);
    EXPECT_LT(error.mm, 3);
    EXPECT_NEAR(error.degrees, has_print ? 0 : 90, 0.6);
    EXPECT_EQ(moves[0].move->confidence > 0.95, has_print) << moves[0].move->confidence;
  }
}

TEST(Moves, ACanKeepsTheTurnThatNothingTells) {
  const Solid can = can_on_table(0.14, 0.16, 0, 0);
  const Solid after = moved(can, motion(0.1, 40, 0));
  const auto moves = moves_of(seen_after(with(table(false), can), with(table(false), after)));
  ASSERT_EQ(moves.size(), 1U);
  const Error error = error_of(*moves[0].move, can, after);
  EXPECT_LT(error.mm, 3);
  EXPECT_LT(error.degrees, 1);
}

TEST(Moves, OfTwoEqualBoxesTheOneThatMoved) {
  Solid first = box_on_table(kSize, -0.2, 0, 20, false, 1);
  Solid second = box_on_table(kSize, 0.2, 0, 20, false, 1);
  second.name = second.object = "other";
  const Scene before = with(with(table(false), first), second);
  const Solid after = moved(second, motion(0.1, -60, 30));
  const auto moves = moves_of(seen_after(before, with(with(table(false), first), after)));
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_THAT(moves[0].effect, testing::StartsWith("moves \"other\" by 100 mm and 30 degrees"));
  EXPECT_LT(error_of(*moves[0].move, second, after).mm, 3);
}

TEST(Moves, OneOfTwoEqualPlacesIsNotGuessed) {
  const Solid box = box_on_table(kSize, 0, 0.3, 20, false, 1);
  const Solid left = box_on_table(kSize, -0.25, -0.1, 20, false, 1);
  const Solid right = box_on_table(kSize, 0.2, -0.1, 50, false, 1);
  const auto proposals = seen_after(with(table(false), box), with(with(table(false), left), right));
  EXPECT_TRUE(moves_of(proposals).empty());
  EXPECT_GE(proposals.size(), 3U);
}

TEST(Moves, AnotherPrintOnABoxOfTheSameSizeIsAnotherBox) {
  const Solid box = box_on_table(kSize, 0, 0, 20, true, 1);
  const Solid other = box_on_table(kSize, 0.1, 0.05, 50, true, 7);
  const auto proposals = seen_after(with(table(true), box), with(table(true), other));
  EXPECT_TRUE(moves_of(proposals).empty());
  EXPECT_GE(proposals.size(), 2U);
  // The same box there is one that moved.
  const Solid same = box_on_table(kSize, 0.1, 0.05, 50, true, 1);
  EXPECT_EQ(moves_of(seen_after(with(table(true), box), with(table(true), same))).size(), 1U);
}

TEST(Moves, ABoxThatIsHalfHiddenNowIsNone) {
  const Solid box = box_on_table(kSize, 0, 0, 20, false, 1);
  Scene scene = table(false);
  Solid screen = box_on_table({0.5, 0.02, 0.3}, 0.25, 0.1, 0, false, 2);
  screen.name = screen.object = "screen";
  scene.solids.push_back(screen);
  const Solid after = moved(box, motion(0.28, 92, 0));
  EXPECT_TRUE(moves_of(seen_after(with(scene, box), with(scene, after))).empty());
}

TEST(Moves, ContradictionsAreRefused) {
  const Solid box = box_on_table(kSize, 0, 0, 20, false, 1);
  const auto world = look(with(table(false), box), with(table(false), moved(box, motion(0.12, 40, 30))), kView);
  auto proposals = propose(world->snapshot(), 50, {});
  ASSERT_EQ(proposals.size(), 1U);
  const auto twice = merge_edits(world->model, {proposals[0], proposals[0]});
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error().message, testing::HasSubstr("accept one of them"));
  // What is removed where it was contradicts that it moved.
  for (auto& other : propose(world->snapshot(), 50, {.moves = false})) {
    if (other.kind == ChangeKind::removal) proposals.push_back(std::move(other));
  }
  ASSERT_GE(proposals.size(), 2U);
  EXPECT_FALSE(merge_edits(world->model, proposals));
}

}  // namespace
}  // namespace meshloop
