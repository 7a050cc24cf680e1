#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <set>

#include "boxes.h"
#include "server/adjust/proposal.h"

namespace meshloop {
namespace {

using boxes::Box;
using boxes::make_world;
using boxes::World;
using boxes::WorldOptions;

const Box kWall{{-2, -2, 2}, {2, 2, 2.1}, 1};

Model after(const World& world, const std::vector<Proposal>& accepted) {
  const auto edits = merge_edits(world.model, accepted);
  EXPECT_TRUE(edits.has_value());
  auto changed = apply(world.model, edits->edits, 2);
  EXPECT_TRUE(changed.has_value());
  return *changed;
}

std::size_t triangles_in(const Submesh& mesh, const Eigen::AlignedBox3f& box) {
  std::size_t count = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    count += box.contains(mesh.positions[a]) && box.contains(mesh.positions[b]) && box.contains(mesh.positions[c]);
  }
  return count;
}

using Corners = std::array<std::array<float, 3>, 3>;

Corners corners_of(const Submesh& mesh, const Triangle& triangle) {
  Corners corners{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& p = mesh.positions[triangle[i]];
    corners[i] = {p.x(), p.y(), p.z()};
  }
  return corners;
}

// One mesh of two, without welding them.
Submesh joined(Submesh first, const Submesh& second) {
  const auto offset = static_cast<std::uint32_t>(first.positions.size());
  first.positions.insert(first.positions.end(), second.positions.begin(), second.positions.end());
  first.colors.insert(first.colors.end(), second.colors.begin(), second.colors.end());
  for (const auto& [a, b, c] : second.triangles) first.triangles.push_back({a + offset, b + offset, c + offset});
  return first;
}

// A box in front of the wall, modelled as node 2, that is gone in reality.
Box gone_box() {
  return {{-0.2, -0.15, 1.4}, {0.2, 0.15, 1.6}, 2, false};
}

TEST(Removal, TakesTheFaceThatIsSeenThroughAndKeepsTheRest) {
  const auto world = make_world({kWall, gone_box()}, Pose::Identity());
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  EXPECT_EQ(proposals[0].kind, ChangeKind::removal);
  const Model model = after(*world, proposals);
  const Submesh& left = *model.find(2)->submesh;
  const Eigen::AlignedBox3f front{Eigen::Vector3f{-1, -1, 1.399f}, Eigen::Vector3f{1, 1, 1.401f}};
  const Eigen::AlignedBox3f back{Eigen::Vector3f{-1, -1, 1.599f}, Eigen::Vector3f{1, 1, 1.601f}};
  EXPECT_EQ(triangles_in(*world->model.find(2)->submesh, front), 2u * 40u * 30u);
  EXPECT_EQ(triangles_in(left, front), 0u);
  EXPECT_EQ(triangles_in(left, back), 2u * 40u * 30u);
  EXPECT_EQ(model.find(1)->submesh, world->model.find(1)->submesh) << "the wall behind is not touched";
}

TEST(Removal, KeepsTheBackOfAThinBoxEvenWhenItIsCoarse) {
  // 2 mm thick, two triangles a face: front and back differ by the least that can be told.
  Box thin{{-0.2, -0.15, 1.4}, {0.2, 0.15, 1.404}, 2, false};
  thin.edge_m = 10;
  WorldOptions options;
  options.threshold_m = 0.003;
  const auto world = make_world({kWall, thin}, Pose::Identity(), options);
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  const Model model = after(*world, proposals);
  ASSERT_NE(model.find(2), nullptr);
  const Eigen::AlignedBox3f back{Eigen::Vector3f{-1, -1, 1.4039f}, Eigen::Vector3f{1, 1, 1.4041f}};
  EXPECT_EQ(triangles_in(*model.find(2)->submesh, back), 2u);
}

TEST(Removal, LeavesUntouchedTrianglesBitIdentical) {
  const auto world = make_world({kWall, gone_box()}, look_at({0.3, -0.2, 0.1}, {0, 0, 1.6}, {0, -1, 0}));
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  const Model model = after(*world, proposals);
  const Submesh& before = *world->model.find(2)->submesh;
  const Submesh& now = *model.find(2)->submesh;
  const auto bytes = [](const Submesh& mesh, const Triangle& t) {
    std::array<Eigen::Vector3f, 3> corners{mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
    std::array<char, sizeof corners> raw{};
    std::memcpy(raw.data(), corners.data(), sizeof corners);
    return raw;
  };
  // What is left appears in the same order in what was there.
  std::size_t t = 0;
  for (const auto& triangle : now.triangles) {
    while (t < before.triangles.size() && bytes(before, before.triangles[t]) != bytes(now, triangle)) ++t;
    ASSERT_LT(t, before.triangles.size());
    ++t;
  }
  EXPECT_EQ(before.triangles.size() - now.triangles.size(), proposals[0].triangles_removed);
}

TEST(Removal, NeedsMeasuredEvidence) {
  auto world = make_world({kWall, gone_box()}, Pose::Identity());
  // The sensor sees nothing on the right half; the region (of an earlier frame, say) still covers it.
  for (int y = 0; y < 240; ++y) {
    for (int x = 160; x < 320; ++x) world->frame.depth(x, y) = 0;
  }
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  const Model model = after(*world, proposals);
  const Eigen::AlignedBox3f right{Eigen::Vector3f{0.005f, -1, 1.399f}, Eigen::Vector3f{1, 1, 1.401f}};
  const Eigen::AlignedBox3f left{Eigen::Vector3f{-1, -1, 1.399f}, Eigen::Vector3f{-0.005f, 1, 1.401f}};
  EXPECT_EQ(triangles_in(*model.find(2)->submesh, right), triangles_in(*world->model.find(2)->submesh, right));
  EXPECT_EQ(triangles_in(*model.find(2)->submesh, left), 0u);
}

TEST(Removal, DoesNotTouchAnotherNodeInFrontOfTheRegion) {
  // A real post stands before the box that is gone.
  const Box post{{-0.02, -1, 1.0}, {0.02, 1, 1.05}, 3};
  const auto world = make_world({kWall, gone_box(), post}, Pose::Identity());
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 2u) << "the post divides the region";
  const Model model = after(*world, proposals);
  EXPECT_EQ(model.find(3)->submesh, world->model.find(3)->submesh);
  EXPECT_EQ(model.find(1)->submesh, world->model.find(1)->submesh);
  // Behind the post the box's front survives: nothing was seen there.
  const Eigen::AlignedBox3f behind{Eigen::Vector3f{-0.022f, -1, 1.399f}, Eigen::Vector3f{0.022f, 1, 1.401f}};
  EXPECT_GT(triangles_in(*model.find(2)->submesh, behind), 0u);
}

TEST(Removal, KeepsWhatTouchesWhatGoes) {
  // A wall in one node with the post that stands against it. The wall is gone, the post is not.
  const Box gone{{-0.5, -0.4, 1.5}, {0.5, 0.4, 1.52}, 2, false};
  const Box post{{-0.05, -0.2, 1.45}, {0.05, 0.2, 1.5}, 3};
  const Pose camera = look_at({0.3, -0.2, 0.1}, {0, 0, 1.5}, {0, -1, 0});
  auto world = make_world({kWall, gone, post}, camera);
  const Submesh wall = boxes::tessellate(gone);
  world->model.nodes[1] = make_node(2, "both", joined(wall, boxes::tessellate(post)));
  world->model.nodes.pop_back();
  for (auto& index : world->comparison.node_index.pixels()) index = std::min(index, 2U);
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_FALSE(proposals.empty());
  const Submesh left = *after(*world, proposals).find(2)->submesh;
  const auto first_of_post = static_cast<std::ptrdiff_t>(wall.triangles.size());
  const Submesh& before = *world->model.find(2)->submesh;
  std::set<Corners> stays;
  for (const auto& triangle : left.triangles) stays.insert(corners_of(left, triangle));
  std::size_t lost = 0;
  std::for_each(before.triangles.begin() + first_of_post, before.triangles.end(),
                [&](const Triangle& triangle) { lost += 1 - stays.count(corners_of(before, triangle)); });
  EXPECT_EQ(lost, 0u) << "triangles of the post";
  const Eigen::AlignedBox3f front{Eigen::Vector3f{-1, -1, 1.499F}, Eigen::Vector3f{-0.1F, 1, 1.501F}};
  EXPECT_EQ(triangles_in(left, front), 0u);
}

TEST(Removal, TwoRegionsOnOneNodeBecomeOneEdit) {
  const Box post{{-0.02, -1, 1.0}, {0.02, 1, 1.05}, 3};
  const auto world = make_world({kWall, gone_box(), post}, Pose::Identity());
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 2u);
  const auto both = merge_edits(world->model, proposals);
  ASSERT_TRUE(both.has_value());
  ASSERT_EQ(both->edits.size(), 1u);
  const auto count = world->model.find(2)->submesh->triangles.size();
  EXPECT_EQ(std::get<ReplaceSubmesh>(both->edits[0]).submesh->triangles.size(),
            count - proposals[0].triangles_removed - proposals[1].triangles_removed);
  const auto one = merge_edits(world->model, {proposals[1]});
  ASSERT_TRUE(one.has_value());
  EXPECT_EQ(std::get<ReplaceSubmesh>(one->edits[0]).submesh->triangles.size(), count - proposals[1].triangles_removed);
}

TEST(Removal, ANodeWithoutTrianglesIsRemoved) {
  auto world = make_world({kWall, gone_box()}, Pose::Identity());
  // A sheet instead of a box: nothing is hidden.
  Submesh sheet = boxes::tessellate({{-0.2, -0.15, 1.4}, {0.2, 0.15, 1.4}, 2, false});
  std::vector<bool> front(sheet.triangles.size(), false);
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
    const auto& [a, b, c] = sheet.triangles[t];
    const auto n = (sheet.positions[b] - sheet.positions[a]).cross(sheet.positions[c] - sheet.positions[a]);
    front[t] = n.z() < 0;
  }
  world->model.nodes[1] = make_node(2, "sheet", keep_triangles(sheet, front));
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  ASSERT_EQ(proposals[0].edits.size(), 1u);
  ASSERT_TRUE(std::holds_alternative<RemoveNode>(proposals[0].edits[0]));
  EXPECT_EQ(after(*world, proposals).find(2), nullptr);
}

TEST(Removal, FollowsANodeThatWasMoved) {
  const auto still = make_world({kWall, gone_box()}, Pose::Identity());
  auto world = make_world({kWall, gone_box()}, Pose::Identity());
  // The same place in the world, by a node whose geometry lies elsewhere in its own frame.
  const Pose T_world_node =
      make_pose({0.3, -0.2, 0.1}, Eigen::Quaterniond{Eigen::AngleAxisd{0.7, Eigen::Vector3d::UnitY()}});
  Submesh mesh = *world->model.find(2)->submesh;
  for (auto& p : mesh.positions) p = (T_world_node.inverse() * p.cast<double>()).cast<float>();
  world->model.nodes[1] = make_node(2, "moved", std::move(mesh), T_world_node);
  const auto expected = propose(still->snapshot(), 10, {});
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  EXPECT_EQ(proposals[0].triangles_removed, expected.at(0).triangles_removed);
}

// Silhouette pixels of node 2 become undecided, as they are with a k-sigma threshold.
void blur_silhouettes(World& world) {
  auto& c = world.comparison;
  Image<Label> labels = c.labels;
  for (int y = 1; y < labels.height() - 1; ++y) {
    for (int x = 1; x < labels.width() - 1; ++x) {
      const bool inside = c.node_index(x - 1, y) == 2 && c.node_index(x + 1, y) == 2 && c.node_index(x, y - 1) == 2 &&
                          c.node_index(x, y + 1) == 2;
      if (c.node_index(x, y) != 2 || inside) continue;
      labels(x, y) = Label::undecided;
      world.regions.ids(x, y) = 0;
      c.threshold_m(x, y) = std::numeric_limits<float>::infinity();
    }
  }
  c.labels = labels;
}

TEST(Removal, TakesTheUndecidedOutlineOfWhatIsSeenThrough) {
  const Pose camera = look_at({0.3, -0.2, 0.1}, {0, 0, 1.6}, {0, -1, 0});
  const auto sharp = make_world({kWall, gone_box()}, camera);
  auto blurred = make_world({kWall, gone_box()}, camera);
  blur_silhouettes(*blurred);
  const auto removed = [](const World& world) { return propose(world.snapshot(), 10, {}).at(0).triangles_removed; };
  EXPECT_GE(removed(*blurred), removed(*sharp));
}

TEST(Removal, KeepsAnUndecidedOutlineThatIsNotSeenThrough) {
  // The right half of the box is still there, and nothing of it goes but at the border of what is seen through.
  auto world = make_world({kWall, gone_box(), {{0, -0.15, 1.4}, {0.2, 0.15, 1.6}, 0}}, Pose::Identity());
  blur_silhouettes(*world);
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 1u);
  const Eigen::AlignedBox3f right{Eigen::Vector3f{0.01f, -1, 1}, Eigen::Vector3f{1, 1, 2}};
  EXPECT_EQ(triangles_in(*after(*world, proposals).find(2)->submesh, right),
            triangles_in(*world->model.find(2)->submesh, right));
}

TEST(Removal, TakesSmallPiecesThatItCutsLoose) {
  // Noise left one pixel in the middle unchanged.
  auto world = make_world({kWall, gone_box()}, Pose::Identity());
  for (int y = 118; y < 123; ++y) {
    for (int x = 158; x < 163; ++x) world->regions.ids(x, y) = 0;
  }
  const Eigen::AlignedBox3f front{Eigen::Vector3f{-1, -1, 1.399f}, Eigen::Vector3f{1, 1, 1.401f}};
  const auto left = [&](std::size_t smallest) {
    AdjustOptions options;
    options.min_patch_triangles = smallest;
    return triangles_in(*after(*world, propose(world->snapshot(), 10, options)).find(2)->submesh, front);
  };
  EXPECT_GT(left(0), 0u);
  EXPECT_EQ(left(20), 0u);
}

TEST(Removal, IgnoresRegionsThatAreNotConfirmed) {
  auto world = make_world({kWall, gone_box()}, Pose::Identity());
  for (auto& region : world->regions.regions) region.confirmed = false;
  EXPECT_TRUE(propose(world->snapshot(), 10, {}).empty());
}

}  // namespace
}  // namespace meshloop
