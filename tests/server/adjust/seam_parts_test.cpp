// The small parts of stitching.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "common/mesh/triangulate.h"
#include "server/adjust/border_match.h"
#include "server/adjust/flip_edges.h"
#include "server/adjust/split_vertices.h"

namespace meshloop::adjust {
namespace {

double area2(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c) {
  const Eigen::Vector2d along = (b - a).cast<double>();
  const Eigen::Vector2d across = (c - a).cast<double>();
  return along.y() * across.x() - along.x() * across.y();
}

// A straight row of corners, which ears cut into slivers, and a ragged one opposite.
TEST(FlipEdges, LeavesNoSliverOnAStraightBorder) {
  std::mt19937 random{3};
  std::uniform_real_distribution<float> ragged{-0.3f, 0.3f};
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i <= 30; ++i) points.emplace_back(static_cast<float>(i), 0.001f * static_cast<float>(i % 2));
  for (int i = 30; i >= 0; --i) points.emplace_back(static_cast<float>(i) + ragged(random), -2 + ragged(random));
  FlatRing ring;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    ring.corners.push_back(i);
    ring.points.emplace_back(points[i].x(), -points[i].y());
  }
  std::vector<Triangle> triangles;
  append_flat_polygon({ring}, triangles);
  ASSERT_EQ(triangles.size(), points.size() - 2);
  double before = 0;
  for (const auto& t : triangles) before += area2(points[t[0]], points[t[1]], points[t[2]]);
  flip_to_delaunay(triangles, [&](std::uint32_t i) { return points[i]; });
  double after = 0;
  for (const auto& t : triangles) {
    EXPECT_GT(area2(points[t[0]], points[t[1]], points[t[2]]), 0.1);
    after += area2(points[t[0]], points[t[1]], points[t[2]]);
  }
  EXPECT_NEAR(before, after, 1e-4);
}

TEST(SplitVertices, GivesEachFanItsOwn) {
  Submesh bow_tie;  // two triangles that share vertex 0
  bow_tie.positions = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {-1, 0, 1}, {-1, -1, 1}};
  bow_tie.colors.assign(5, {1, 2, 3});
  bow_tie.triangles = {{0, 1, 2}, {0, 3, 4}};
  std::vector<std::array<std::uint32_t, 2>> border{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {3, 4}, {4, 0}};
  split_vertices(bow_tie, border);
  ASSERT_EQ(bow_tie.positions.size(), 6U);
  EXPECT_EQ(bow_tie.positions[5], bow_tie.positions[0]);
  EXPECT_EQ(bow_tie.colors.size(), 6U);
  std::set<std::uint32_t> begins;
  std::set<std::uint32_t> ends;
  for (const auto& [from, to] : border) {
    EXPECT_TRUE(begins.insert(from).second);
    EXPECT_TRUE(ends.insert(to).second);
  }
  EXPECT_EQ(begins, ends);
  EXPECT_TRUE(validate(bow_tie));
}

TEST(BorderMatch, FindsWhatIsBetweenTwoPlaces) {
  OpenBorder border(6);  // a row of vertices 2 pixels apart
  for (std::uint32_t i = 0; i < border.size(); ++i) {
    border[i].in_picture = {10 + 2 * static_cast<float>(i), 20, 1};
    if (i + 1 < border.size()) border[i].next = i + 1;
    if (i > 0) border[i].previous = i - 1;
  }
  const BorderLookup lookup{border, 64, 48, 4};
  const auto right = lookup.find({19.5f, 21, 1.001f}, {-1, 0}, 0.01f);
  const auto left = lookup.find({12.5f, 21, 1.001f}, {-1, 0}, 0.01f);
  ASSERT_TRUE(right && left);
  EXPECT_EQ(right->vertex, 4U);
  EXPECT_EQ(left->vertex, 1U);
  EXPECT_EQ(vertices_between(border, *right, *left, 10), (std::vector<std::uint32_t>{5, 4, 3, 2, 1}));
  EXPECT_FALSE(vertices_between(border, *left, *right, 10)) << "the border ends before it comes round";
  EXPECT_FALSE(lookup.find({15, 21, 1.001f}, {1, 0}, 0.01f)) << "runs the same way";
  EXPECT_FALSE(lookup.find({15, 25, 1.001f}, {-1, 0}, 0.01f)) << "too far";
  EXPECT_FALSE(lookup.find({15, 21, 1.1f}, {-1, 0}, 0.01f)) << "behind";
}

}  // namespace
}  // namespace meshloop::adjust
