#include "common/mesh/lattice.h"

#include <gtest/gtest.h>

#include <limits>
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

}  // namespace
}  // namespace meshloop
