#include "common/mesh/lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <random>

namespace meshloop {
namespace {

Submesh triangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  return {{a, b, c}, {}, {{0, 1, 2}}};
}

TEST(Lattice, MovesNoPositionFartherThanHalfASpacingPerAxis) {
  std::mt19937 random{4};
  std::uniform_real_distribution<float> metres{-20, 20};
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3f p{metres(random), metres(random), metres(random)};
    const Submesh snapped = snap_to_lattice(triangle(p, p + Eigen::Vector3f{1, 0, 0}, p + Eigen::Vector3f{0, 1, 0}));
    ASSERT_EQ(snapped.positions.size(), 3u);
    EXPECT_LE((snapped.positions[0] - p).cwiseAbs().maxCoeff(), kLatticeSpacing_m / 2);
    EXPECT_TRUE(is_on_lattice(snapped));
  }
}

TEST(Lattice, ACoarserLatticeIsPartOfTheFinestOne) {
  const Submesh metres = triangle({0.1003f, 0.2f, -0.3f}, {1.1f, 0, 0}, {0, 5.5f, 0.7f});
  for (const int coarsening : {1, 2, 4, 8}) {
    const Submesh snapped = snap_to_lattice(metres, coarsening);
    EXPECT_TRUE(is_on_lattice(snapped));
    EXPECT_GE(coarsening_of(snapped), coarsening);
    const float half_m = kLatticeSpacing_m * static_cast<float>(coarsening) / 2;
    EXPECT_LE((snapped.positions[0] - metres.positions[0]).cwiseAbs().maxCoeff(), half_m);
  }
  const float d = kLatticeSpacing_m;
  EXPECT_EQ(coarsening_of(triangle({0, 0, 0}, {3 * d, 0, 0}, {0, 4 * d, 0})), 1);
  EXPECT_EQ(coarsening_of(triangle({0, 0, 0}, {-12 * d, 0, 0}, {0, 8 * d, 0})), 4);
  EXPECT_EQ(coarsening_of(triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})), kMaxCoarsening);
}

TEST(Lattice, SomeVerticesStayOnTheFinestOne) {
  const float d = kLatticeSpacing_m;
  const Submesh exact = triangle({3 * d, 5 * d, -7 * d}, {1 + 3.2f * d, 0, 0}, {0, 5 + d, 0});
  const std::vector<std::uint32_t> finest{0, 1};
  const Submesh snapped = snap_to_lattice(exact, 4, finest);
  EXPECT_EQ(snapped.positions[0], exact.positions[0]);
  EXPECT_EQ(snapped.positions[1], Eigen::Vector3f(1 + 3 * d, 0, 0));
  EXPECT_EQ(snapped.positions[2], Eigen::Vector3f(0, 5, 0));
  EXPECT_TRUE(is_on_lattice(snapped.positions[2], 4));
  EXPECT_FALSE(is_on_lattice(snapped.positions[1], 2));
}

TEST(Lattice, SnappingTwiceChangesNothing) {
  const Submesh once = snap_to_lattice(triangle({0.1f, 0.2f, 0.3f}, {1.1f, 0, 0}, {0, 5.5f, 0}));
  EXPECT_EQ(content_hash(snap_to_lattice(once)), content_hash(once));
}

TEST(Lattice, PositionsBetweenPointsAndNaNAreNotOnIt) {
  EXPECT_FALSE(is_on_lattice(triangle({0.1f, 0, 0}, {1, 0, 0}, {0, 1, 0})));
  EXPECT_FALSE(is_on_lattice(triangle({std::numeric_limits<float>::quiet_NaN(), 0, 0}, {1, 0, 0}, {0, 1, 0})));
}

TEST(Lattice, GivesOneShapeOneHashWhateverTheSignOfZero) {
  const Submesh minus = triangle({-0.0f, -1e-5f, 0}, {1, -0.0f, 0}, {0, 1, -0.0f});
  const Submesh plus = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  EXPECT_FALSE(is_on_lattice(minus));
  EXPECT_TRUE(is_on_lattice(plus));
  EXPECT_EQ(content_hash(snap_to_lattice(minus)), content_hash(plus));
}

TEST(Lattice, DropsTrianglesThatLoseTheirAreaAndTheirVertices) {
  Submesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  for (const float x : {5.0f, 5.00001f, 5.00002f}) mesh.positions.emplace_back(x, x, x);
  mesh.triangles.push_back({3, 4, 5});
  const Submesh snapped = snap_to_lattice(mesh);
  EXPECT_EQ(snapped.positions.size(), 3u);
  EXPECT_EQ(snapped.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(Lattice, MayLeaveNothing) {
  EXPECT_TRUE(snap_to_lattice(triangle({0, 0, 0}, {1e-5f, 0, 0}, {0, 1e-5f, 0})).triangles.empty());
}

// The products of the long sides differ in bits that single precision does not have.
TEST(Lattice, KeepsALongTriangleOneSpacingWide) {
  const float d = kLatticeSpacing_m;
  const Eigen::Vector3f b{8193 * d, 8192 * d, 0};
  const Eigen::Vector3f c{8194 * d, 8193 * d, 0};
  EXPECT_EQ(snap_to_lattice(triangle({0, 0, 0}, b, c)).triangles.size(), 1u);
}

// A sliver whose middle corner comes to lie on its longest edge: without it two short edges would face a long one.
TEST(Lattice, FlipsWhatBecomesFlatSoThatNothingOpens) {
  constexpr float a = kLatticeSpacing_m;
  Submesh mesh;
  mesh.positions = {{0, 0, 0}, {20 * a, 0, 0}, {10 * a, 0.3f * a, 0}, {10 * a, 15 * a, 0}, {10 * a, -15 * a, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 3}, {1, 0, 4}};
  const Submesh snapped = snap_to_lattice(mesh);
  ASSERT_EQ(snapped.triangles.size(), 4U);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const auto& t : snapped.triangles) {
    EXPECT_TRUE(has_area(snapped, t));
    for (std::size_t k = 0; k < 3; ++k) sides[std::minmax(t[k], t[(k + 1) % 3])] += t[k] < t[(k + 1) % 3] ? 1 : -1;
  }
  EXPECT_EQ(std::count_if(sides.begin(), sides.end(), [](const auto& edge) { return edge.second != 0; }), 4);  // around
}

// The corner that the longest edge comes to lie on is one that stays where it is.
TEST(Lattice, FlipsWhatBecomesFlatBesideAVertexOfTheFinestOne) {
  constexpr float a = 4 * kLatticeSpacing_m;
  Submesh mesh;
  mesh.positions = {
      {0, 0.1f * a, 0}, {20 * a, 0.1f * a, 0}, {10.25f * a, 0, 0}, {10 * a, 15 * a, 0}, {10 * a, -15 * a, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 4, 2}, {2, 4, 1}};
  const std::vector<std::uint32_t> finest{2};
  const Submesh snapped = snap_to_lattice(mesh, 4, finest);
  ASSERT_EQ(snapped.triangles.size(), 4U);
  EXPECT_EQ(snapped.positions[2], mesh.positions[2]);
  for (const auto& t : snapped.triangles) EXPECT_TRUE(has_area(snapped, t));
}

// As in double precision, of thin and fat triangles on the lattice.
TEST(Lattice, AreaIsToldExactly) {
  std::mt19937 random{7};
  int flat = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto coordinate = [&](int range) {
      return kLatticeSpacing_m *
             static_cast<float>(static_cast<int>(random() % static_cast<unsigned>(range)) - range / 2);
    };
    const int range = i % 2 == 0 ? 4 : 40'000;
    const Eigen::Vector3f p{coordinate(range), coordinate(range), coordinate(range)};
    const Eigen::Vector3f step{coordinate(8), coordinate(8), coordinate(8)};
    const Eigen::Vector3f q = p + step * static_cast<float>(random() % 5);
    const Eigen::Vector3f r = p + step * static_cast<float>(random() % 5) + Eigen::Vector3f{coordinate(3), 0, 0};
    const Submesh mesh = triangle(p, q, r);
    const bool truth = !(q - p).cast<double>().cross((r - p).cast<double>()).isZero(0);
    EXPECT_EQ(has_area(mesh, mesh.triangles[0]), truth) << i;
    flat += truth ? 0 : 1;
  }
  EXPECT_GT(flat, 1000);
  EXPECT_LT(flat, 19'000);
}

}  // namespace
}  // namespace meshloop
