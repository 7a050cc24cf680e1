#include "common/mesh/triangulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

namespace meshloop {
namespace {

TEST(Triangulate, RefusesWhatIsNoPolygon) {
  std::vector<Triangle> triangles;
  const std::vector<Eigen::Vector3f> positions(3, Eigen::Vector3f::Zero());
  EXPECT_FALSE(append_polygon(std::vector<std::uint32_t>{0, 1}, positions, triangles));
  EXPECT_FALSE(append_polygon(std::vector<std::uint32_t>{0, 1, 3}, positions, triangles));
  EXPECT_TRUE(triangles.empty());
  // No area at all: no triangles, and an end.
  EXPECT_TRUE(append_polygon(std::vector<std::uint32_t>{0, 1, 2, 0, 1}, positions, triangles));
  EXPECT_TRUE(triangles.empty());
}

/// The corners' places, and the sum of the triangles' areas as they are, and without regard to which way they turn.
struct Covered {
  double signed_area = 0;
  double area = 0;
};

Covered covered_by(const std::vector<FlatRing>& rings) {
  std::map<std::uint32_t, Eigen::Vector2d> places;
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.corners.size(); ++i) places[ring.corners[i]] = ring.points[i];
  }
  std::vector<Triangle> triangles;
  append_flat_polygon(rings, triangles);
  Covered covered;
  for (const auto& [a, b, c] : triangles) {
    const Eigen::Vector2d ab = places[b] - places[a];
    const Eigen::Vector2d ac = places[c] - places[a];
    const double area = (ab.x() * ac.y() - ab.y() * ac.x()) / 2;
    covered.signed_area += area;
    covered.area += std::abs(area);
  }
  return covered;
}

FlatRing rectangle(double x0, double y0, double x1, double y1, std::uint32_t first) {
  FlatRing ring;
  ring.points = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  ring.corners = {first, first + 1, first + 2, first + 3};
  return ring;
}

FlatRing hole(double x0, double y0, double x1, double y1, std::uint32_t first) {
  FlatRing ring = rectangle(x0, y0, x1, y1, first);
  std::swap(ring.points[1], ring.points[3]);
  std::swap(ring.corners[1], ring.corners[3]);
  return ring;
}

TEST(Triangulate, LeavesHolesOpen) {
  const auto one = covered_by({rectangle(0, 0, 4, 4, 0), hole(1, 1, 2, 2, 4)});
  EXPECT_DOUBLE_EQ(one.area, 15);
  EXPECT_DOUBLE_EQ(one.signed_area, 15);
  // The second bridge begins at a corner that the first one has put into the ring twice.
  const auto two = covered_by({rectangle(0, 0, 4, 4, 0), hole(1, 1, 1.8, 1.8, 4), hole(1.2, 0.6, 1.5, 0.9, 8)});
  EXPECT_NEAR(two.area, 16 - 0.64 - 0.09, 1e-9);
}

TEST(Triangulate, ManyHolesInOnePolygon) {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> side{0.1, 0.9};
  for (int i = 0; i < 300; ++i) {
    // One hole or none in each cell of a grid.
    std::vector<FlatRing> rings{rectangle(0, 0, 5, 5, 0)};
    double area = 25;
    for (int cell = 0; cell < 25; ++cell) {
      if (random() % 3 == 0) continue;
      const double x = cell % 5 + 0.05;
      const double y = cell / 5 + 0.05;
      const double w = side(random);
      const double h = side(random);
      rings.push_back(hole(x, y, x + w, y + h, static_cast<std::uint32_t>(4 * rings.size())));
      area -= w * h;
    }
    const auto covered = covered_by(rings);
    EXPECT_NEAR(covered.area, area, 1e-9) << i;
    EXPECT_NEAR(covered.signed_area, area, 1e-9) << i;
  }
}

TEST(Triangulate, HolesMayTouch) {
  FlatRing diamond;
  diamond.points = {{2, 1}, {1, 2}, {2, 3}, {3, 2}};
  diamond.corners = {4, 5, 6, 7};
  // At the middle of the outer ring's side, and each other.
  auto outer = rectangle(0, 0, 4, 4, 0);
  outer.points.insert(outer.points.begin() + 1, Eigen::Vector2d{2, 0});
  outer.corners.insert(outer.corners.begin() + 1, 8);
  FlatRing below;
  below.points = {{2, 0}, {1.5, 0.5}, {2, 1}, {2.5, 0.5}};
  below.corners = {8, 9, 4, 10};
  const auto covered = covered_by({outer, diamond, below});
  EXPECT_NEAR(covered.area, 16 - 2 - 0.5, 1e-12);
  EXPECT_NEAR(covered.signed_area, 16 - 2 - 0.5, 1e-12);
}

}  // namespace
}  // namespace meshloop
