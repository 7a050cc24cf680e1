// Large triangles lose only what is seen through.
#include "server/adjust/cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>

#include "boxes.h"
#include "common/mesh/lattice.h"
#include "kinect_camera.h"
#include "server/adjust/outline.h"

namespace meshloop {
namespace {

using boxes::Box;
using boxes::make_world;
using boxes::World;
using boxes::WorldOptions;

constexpr double kOpening_m = 0.3;

/// A wall of two triangles, facing -z.
Submesh sheet(float half, float z) {
  Submesh wall;
  wall.positions = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
  wall.triangles = {{0, 2, 1}, {0, 3, 2}};
  wall.colors = {{0, 80, 160}, {0, 80, 160}, {160, 80, 0}, {160, 80, 0}};
  return wall;
}

/// The model has a wall at z = 1 without an opening; in reality there is one of 30 x 30 cm, through which another wall
/// is seen. More real things may stand around.
std::unique_ptr<World> world_with_opening(const Pose& camera, double noise, const Submesh& wall,
                                          const std::vector<Box>& more = {}) {
  constexpr double kHalf = kOpening_m / 2;
  const auto half = static_cast<double>(wall.bounds().max().x());
  const Box modelled{{-half, -half, 1}, {half, half, 1.05}, 1, false, 100};
  const Box behind{{-40, -40, 1.6}, {40, 40, 1.7}, 2, true, 100};
  std::vector<Box> boxes{modelled, behind};
  boxes.push_back({{-half, -half, 1}, {half, -kHalf, 1.002}});
  boxes.push_back({{-half, kHalf, 1}, {half, half, 1.002}});
  boxes.push_back({{-half, -kHalf, 1}, {-kHalf, kHalf, 1.002}});
  boxes.push_back({{kHalf, -kHalf, 1}, {half, kHalf, 1.002}});
  boxes.insert(boxes.end(), more.begin(), more.end());
  WorldOptions options;
  options.depth = test::kinect_camera();
  options.noise = noise;
  options.threshold_m = 0.02;
  options.sensor = SensorModel{SensorModel::Kind::kinect1};
  auto world = make_world(boxes, camera, options);
  world->model.nodes[0] = make_node(1, "wall", wall);
  return world;
}

double area_of(const Submesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.positions[a].cast<double>();
    area += (mesh.positions[b].cast<double>() - p).cross(mesh.positions[c].cast<double>() - p).norm() / 2;
  }
  return area;
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Edges that are run through in one direction only.
std::vector<Edge> border_of(const Submesh& mesh) {
  std::map<Edge, int> count;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
  }
  std::vector<Edge> border;
  for (const auto& [edge, times] : count) {
    EXPECT_EQ(times, 1) << "the surface doubles itself";
    if (!count.contains({edge.second, edge.first})) border.push_back(edge);
  }
  return border;
}

/// Every border edge that is not on the wall's own border runs around the opening; no corner lies on another edge.
void expect_no_crack(const Submesh& mesh, float half) {
  const auto border = border_of(mesh);
  const auto is_on_side = [half](const Eigen::Vector3f& p, const Eigen::Vector3f& q, int axis) {
    return p[axis] == q[axis] && std::abs(p[axis]) == half;
  };
  for (const auto& [a, b] : border) {
    const Eigen::Vector3f p = mesh.positions[a];
    const Eigen::Vector3f q = mesh.positions[b];
    const bool is_inner = std::max(p.head<2>().cwiseAbs().maxCoeff(), q.head<2>().cwiseAbs().maxCoeff()) < 0.17F;
    EXPECT_TRUE(is_on_side(p, q, 0) || is_on_side(p, q, 1) || is_inner) << p.transpose() << " to " << q.transpose();
    for (const auto& r : mesh.positions) {
      const float along = (r - p).dot(q - p) / (q - p).squaredNorm();
      // An opening's corner that lies on the edge of two triangles may be two corners, a step of the lattice apart.
      if (along <= 0 || along >= 1 || std::min((r - p).norm(), (r - q).norm()) < 0.001F) continue;
      EXPECT_GT((r - p - along * (q - p)).norm(), kLatticeSpacing_m) << "a corner on the edge of another triangle";
    }
  }
}

Submesh wall_after(const World& world, const std::vector<Proposal>& accepted) {
  const auto edits = merge_edits(world.model, accepted);
  EXPECT_TRUE(edits.has_value());
  return *apply(world.model, edits->edits, 2).value().find(1)->submesh;
}

Proposal removal_of(const World& world) {
  auto proposals = propose(world.snapshot(), 10, {});
  std::erase_if(proposals, [](const Proposal& p) { return p.kind != ChangeKind::removal; });
  EXPECT_EQ(proposals.size(), 1U);
  return proposals.empty() ? Proposal{} : proposals[0];
}

TEST(Cut, AWallOfTwoTrianglesLosesOnlyTheOpening) {
  const std::vector<Pose> cameras{Pose::Identity(), look_at({0.4, -0.3, -0.1}, {0, 0, 1}, {0, -1, 0}),
                                  look_at({-0.5, 0.2, 0.3}, {0, 0, 1}, {0.3, -1, 0}),
                                  look_at({0.2, 0.2, -0.9}, {0, 0, 1}, {0.1, -1, 0})};
  for (const double noise : {0.0, 1.0}) {
    for (const auto& camera : cameras) {
      const auto world = world_with_opening(camera, noise, sheet(1.5F, 1));
      const Proposal proposal = removal_of(*world);
      const Submesh wall = wall_after(*world, {proposal});
      const double removed = area_of(sheet(1.5F, 1)) - area_of(wall);
      std::printf("noise %.0f: %.2f %% of the opening, %zu triangles, %s\n", noise,
                  100 * removed / (kOpening_m * kOpening_m), wall.triangles.size(), proposal.effect.c_str());
      EXPECT_NEAR(removed, kOpening_m * kOpening_m, 0.03 * kOpening_m * kOpening_m);
      for (const auto& p : wall.positions) EXPECT_EQ(p.z(), 1.0F);
      EXPECT_TRUE(is_on_lattice(wall));
      EXPECT_LT(wall.triangles.size(), 100U);
      expect_no_crack(wall, 1.5F);
      EXPECT_EQ(proposal.triangles_removed, 2U);
      EXPECT_EQ(proposal.triangles_added, wall.triangles.size());
    }
  }
}

double removed_from(const Submesh& before, const Submesh& after) {
  return (area_of(before) - area_of(after)) / (kOpening_m * kOpening_m);
}

TEST(Cut, ATriangleMayReachBehindTheCamera) {
  const Submesh wall = sheet(20, 1);
  const auto world = world_with_opening(look_at({0.1, -0.5, 0.6}, {0, 0, 1}, {0, 0, -1}), 0, wall);
  const Submesh after = wall_after(*world, {removal_of(*world)});
  EXPECT_NEAR(removed_from(wall, after), 1, 0.03);
  expect_no_crack(after, 20);
}

TEST(Cut, WhatIsHiddenStays) {
  // A real post, modelled too, stands before the opening: two regions, and a strip of the wall behind it.
  const Box post{{-0.02, -1, 0.5}, {0.02, 1, 0.52}, 3};
  const auto world = world_with_opening(Pose::Identity(), 0, sheet(1.5F, 1), {post});
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 2U);
  const Submesh wall = sheet(1.5F, 1);
  const double hidden = 0.04 / 0.5 / kOpening_m;
  EXPECT_NEAR(removed_from(wall, wall_after(*world, proposals)), 1 - hidden, 0.03);
  // One without the other leaves nothing of the other's lines behind.
  for (const auto& one : proposals) {
    const Submesh after = wall_after(*world, {one});
    EXPECT_NEAR(removed_from(wall, after), (1 - hidden) / 2, 0.02);
    EXPECT_LT(after.triangles.size(), 14U);
    expect_no_crack(after, 1.5F);
  }
}

/// Edges by place that are not run through once in each direction.
std::size_t open_edges(const Submesh& mesh) {
  using Place = std::array<float, 3>;
  std::map<std::pair<Place, Place>, int> count;
  const auto place = [&](std::uint32_t v) {
    return Place{mesh.positions[v].x(), mesh.positions[v].y(), mesh.positions[v].z()};
  };
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Place from = place(t[k]);
      const Place to = place(t[(k + 1) % 3]);
      count[std::minmax(from, to)] += from < to ? 1 : -1;
    }
  }
  return static_cast<std::size_t>(
      std::count_if(count.begin(), count.end(), [](const auto& edge) { return edge.second != 0; }));
}

TEST(Cut, ANeighbourThatStaysWholeGetsTheCorners) {
  // A box of two triangles a face, whose faces have vertices of their own. A notch in one face reaches over its edge.
  const Submesh box = snap_to_lattice(boxes::tessellate({{-0.5, -0.5, 1}, {0.5, 0.5, 2}, 1, true, 100}));
  ASSERT_EQ(box.triangles.size(), 12U);
  ASSERT_EQ(open_edges(box), 0U);
  Removal removal;
  removal.triangles.assign(box.triangles.size(), false);
  const PlaneLine notch{{-0.2, 0.3, 1}, {0.1, 0.3, 1}, {0.13, 0.7, 1}, {-0.2, 0.7, 1}};
  for (std::uint32_t t = 0; t < box.triangles.size(); ++t) {
    const auto& corners = box.triangles[t];
    const bool is_front =
        std::all_of(corners.begin(), corners.end(), [&](auto v) { return box.positions[v].z() == 1.0F; });
    if (is_front) removal.cuts[t] = {notch};
  }
  ASSERT_EQ(removal.cuts.size(), 2U);
  const auto cut = adjust::cut(box, removal);
  // Open are the notch's three sides in the front, and its mouth in the face beside, which is one edge there.
  EXPECT_EQ(cut.taken, 2U);
  EXPECT_EQ(open_edges(cut.submesh), 4U);
  EXPECT_NEAR(area_of(box) - area_of(cut.submesh), 0.2 * (0.3 + 0.315) / 2, 0.001);
}

TEST(Cut, TwoOpeningsInOneTriangle) {
  const Submesh wall = sheet(2, 1);
  Removal removal;
  removal.triangles = {false, false};
  // Both in the triangle above the diagonal.
  removal.cuts[1] = {{{-1, 0.5, 1}, {-0.2, 0.5, 1}, {-0.2, 1.3, 1}, {-1, 1.3, 1}},
                     {{-0.8, 0.1, 1}, {-0.5, 0.1, 1}, {-0.5, 0.4, 1}, {-0.8, 0.4, 1}}};
  const auto cut = adjust::cut(wall, removal);
  EXPECT_NEAR(area_of(wall) - area_of(cut.submesh), 0.64 + 0.09, 0.002);
  EXPECT_EQ(border_of(cut.submesh).size(), 4U + 8U);
}

TEST(Cut, FollowsANodeThatWasMoved) {
  auto world = world_with_opening(Pose::Identity(), 0, sheet(1.5F, 1));
  // The same wall in the world, by a node whose geometry lies elsewhere in its own frame.
  const Pose T_world_node = make_pose(
      {0.25, -0.5, 0.125}, Eigen::Quaterniond{Eigen::AngleAxisd{std::numbers::pi / 2, Eigen::Vector3d::UnitZ()}});
  Submesh moved = sheet(1.5F, 1);
  for (auto& p : moved.positions) p = (T_world_node.inverse() * p.cast<double>()).cast<float>();
  world->model.nodes[0] = make_node(1, "wall", moved, T_world_node);
  EXPECT_NEAR(removed_from(moved, wall_after(*world, {removal_of(*world)})), 1, 0.03);
}

TEST(Cut, AnotherRevisionWithAsManyTrianglesIsRefused) {
  const auto world = world_with_opening(Pose::Identity(), 0, sheet(1.5F, 1));
  const Proposal proposal = removal_of(*world);
  Submesh other = sheet(1.5F, 1);
  std::swap(other.triangles[0], other.triangles[1]);
  world->model.nodes[0] = make_node(1, "wall", other);
  EXPECT_FALSE(merge_edits(world->model, {proposal}));
}

TEST(Cut, ATriangleThatTwoRegionsShareCountsOnce) {
  const Box post{{-0.02, -1, 0.5}, {0.02, 1, 0.52}, 3};
  const auto world = world_with_opening(Pose::Identity(), 0, sheet(1.5F, 1), {post});
  const auto proposals = propose(world->snapshot(), 10, {});
  ASSERT_EQ(proposals.size(), 2U);
  const auto merged = merge_edits(world->model, proposals);
  ASSERT_TRUE(merged);
  EXPECT_EQ(merged->triangles_removed, 2U);
  EXPECT_EQ(merged->triangles_added, wall_after(*world, proposals).triangles.size());
}

TEST(Cut, ALargeTriangleIsNoCrumb) {
  // Small triangles in the middle, which are gone, and eight large ones around, which they touch at four corners.
  constexpr std::uint32_t kCells = 40;
  constexpr auto kHalf = static_cast<float>(kOpening_m / 2);
  Submesh wall = sheet(0.35F, 1);
  wall.colors.clear();
  for (std::uint32_t y = 0; y <= kCells; ++y) {
    for (std::uint32_t x = 0; x <= kCells; ++x) {
      const auto at = [](std::uint32_t i) { return kHalf * (2 * static_cast<float>(i) / kCells - 1); };
      wall.positions.emplace_back(at(x), at(y), 1);
    }
  }
  const auto inner = [](std::uint32_t x, std::uint32_t y) { return 4 + y * (kCells + 1) + x; };
  const std::array<std::uint32_t, 4> foot{inner(0, 0), inner(kCells, 0), inner(kCells, kCells), inner(0, kCells)};
  wall.triangles.clear();
  for (std::uint32_t k = 0; k < 4; ++k) {
    wall.triangles.push_back({k, foot[k], (k + 1) % 4});
    wall.triangles.push_back({(k + 1) % 4, foot[k], foot[(k + 1) % 4]});
  }
  for (std::uint32_t y = 0; y < kCells; ++y) {
    for (std::uint32_t x = 0; x < kCells; ++x) {
      wall.triangles.push_back({inner(x, y), inner(x, y + 1), inner(x + 1, y)});
      wall.triangles.push_back({inner(x + 1, y), inner(x, y + 1), inner(x + 1, y + 1)});
    }
  }
  const auto world = world_with_opening(Pose::Identity(), 0, wall);
  const Submesh left = wall_after(*world, {removal_of(*world)});
  EXPECT_NEAR(removed_from(wall, left), 1, 0.03);
}

TEST(Cut, ColorsAreThoseOfTheTriangle) {
  const auto world = world_with_opening(Pose::Identity(), 0, sheet(1.5F, 1));
  const Submesh wall = wall_after(*world, {removal_of(*world)});
  ASSERT_EQ(wall.colors.size(), wall.positions.size());
  for (std::size_t i = 0; i < wall.positions.size(); ++i) {
    // From (0, 80, 160) at y = -1.5 to (160, 80, 0) at 1.5, in steps of eight.
    EXPECT_NEAR(wall.colors[i].r, 160 * (wall.positions[i].y() + 1.5F) / 3, 4.01);
    EXPECT_EQ(wall.colors[i].g, 80);
    EXPECT_EQ((wall.colors[i].r | wall.colors[i].b) % kCoarseColorStep, 0);
  }
}

TEST(Cut, NothingOfATriangleMayBeLeft) {
  Removal removal;
  removal.triangles = {false, false};
  const Submesh wall = sheet(1, 1);
  const PlaneLine all{{-2, -2, 1}, {2, -2, 1}, {2, 2, 1}, {-2, 2, 1}};
  removal.cuts = {{0, {all}}, {1, {all}}};
  const auto gone = adjust::cut(wall, removal);
  EXPECT_TRUE(gone.submesh.triangles.empty());
  EXPECT_EQ(gone.taken, 2U);
  const PlaneLine beside{{5, 5, 1}, {6, 5, 1}, {6, 6, 1}};
  removal.cuts = {{0, {beside}}};
  const auto same = adjust::cut(wall, removal);
  EXPECT_EQ(same.taken, 0U);
  EXPECT_EQ(same.submesh.triangles, wall.triangles);
}

/// How often lines run around a point of the plane, counter-clockwise.
int turns_around(const std::vector<PlaneLine>& lines, double x, double y) {
  int turns = 0;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Eigen::Vector3d& a = line[i];
      const Eigen::Vector3d& b = line[(i + 1) % line.size()];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double side = (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
      if ((side > 0) == (b.y() > a.y())) turns += b.y() > a.y() ? 1 : -1;
    }
  }
  return turns;
}

/// Of a square of 2 x 2 m, counted on a grid of a centimetre.
double area_outside(const std::vector<PlaneLine>& lines) {
  int outside = 0;
  for (int v = 0; v < 200; ++v) {
    for (int u = 0; u < 200; ++u) outside += turns_around(lines, (u - 99.5) / 100, (v - 99.5) / 100) == 0 ? 1 : 0;
  }
  return outside / 1e4;
}

TEST(Cut, AnyLinesLeaveASurfaceThatFits) {
  // Random polygons, some crossing themselves and each other: what stays is what they do not run around, and faces the
  // same way.
  std::mt19937 random{3};
  std::uniform_real_distribution<double> place{-1.3, 1.3};
  for (int i = 0; i < 200; ++i) {
    Removal removal;
    removal.triangles = {false, false};
    for (int k = 0; k < 1 + i % 3; ++k) {
      PlaneLine line;
      for (int n = 0; n < 3 + i % 5; ++n) line.emplace_back(place(random), place(random), 1);
      removal.cuts[0].push_back(line);
      removal.cuts[1].push_back(line);
    }
    const Submesh wall = sheet(1, 1);
    const auto cut = adjust::cut(wall, removal).submesh;
    EXPECT_NEAR(area_of(cut), area_outside(removal.cuts[0]), 0.02) << i;
    EXPECT_TRUE(cut.triangles.empty() || is_on_lattice(cut)) << i;
    for (const auto& [a, b, c] : cut.triangles) {
      const Eigen::Vector3f p = cut.positions[a];
      const float twice_area = (cut.positions[b] - p).cross(cut.positions[c] - p).z();
      const float longest = std::max(
          {(cut.positions[b] - p).norm(), (cut.positions[c] - p).norm(), (cut.positions[b] - cut.positions[c]).norm()});
      // But for slivers that the lattice turned.
      EXPECT_LT(twice_area, longest * kLatticeSpacing_m) << i;
    }
  }
}

}  // namespace
}  // namespace meshloop
