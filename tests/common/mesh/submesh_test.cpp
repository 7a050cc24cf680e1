#include "common/mesh/submesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace meshloop {
namespace {

using testing::HasSubstr;

// A unit square in two triangles, and a vertex that nothing uses.
Submesh square() {
  return {{{0, 0, 0}, {9, 9, 9}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
          {{1, 1, 1}, {9, 9, 9}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}},
          {{0, 2, 3}, {0, 3, 4}}};
}

TEST(Submesh, TellsBoundsAndRawBytes) {
  EXPECT_EQ(square().bounds().max(), Eigen::Vector3f(9, 9, 9));
  EXPECT_EQ(square().raw_bytes(), 5u * 12 + 5 * 3 + 2 * 12);
  EXPECT_TRUE(Submesh{}.bounds().isEmpty());
}

TEST(Submesh, ValidationAcceptsAMeshWithAndWithoutColors) {
  Submesh mesh = square();
  EXPECT_TRUE(validate(mesh));
  mesh.colors.clear();
  EXPECT_TRUE(validate(mesh));
}

TEST(Submesh, ValidationRefusesWhatLaterStagesCannotUse) {
  Submesh mesh = square();
  mesh.triangles.clear();
  EXPECT_THAT(validate(mesh).error().message, HasSubstr("no triangles"));
  mesh = square();
  mesh.triangles[1][2] = 5;
  EXPECT_THAT(validate(mesh).error().message, HasSubstr("vertex 5"));
  mesh = square();
  mesh.colors.pop_back();
  EXPECT_THAT(validate(mesh).error().message, HasSubstr("colours"));
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -10'001.0f}) {
    mesh = square();
    mesh.positions[3].y() = bad;
    EXPECT_THAT(validate(mesh).error().message, HasSubstr("metres")) << bad;
  }
}

TEST(Submesh, KeepingTrianglesDropsOnlyWhatNothingUses) {
  const Submesh kept = keep_triangles(square(), {false, true});
  EXPECT_EQ(kept.positions, (std::vector<Eigen::Vector3f>{{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(kept.colors, (std::vector<Rgb8>{{1, 1, 1}, {3, 3, 3}, {4, 4, 4}}));
  EXPECT_EQ(kept.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(Submesh, KeepingNoTriangleLeavesNothing) {
  const Submesh kept = keep_triangles(square(), {false, false});
  EXPECT_TRUE(kept.positions.empty() && kept.colors.empty() && kept.triangles.empty());
}

TEST(Submesh, HashNamesTheContent) {
  EXPECT_EQ(content_hash(square()), content_hash(square()));
  Submesh other = square();
  other.positions[0].z() = 1e-6f;
  EXPECT_NE(content_hash(other), content_hash(square()));
  other = square();
  other.colors[0].b = 2;
  EXPECT_NE(content_hash(other), content_hash(square()));
  other = square();
  other.triangles[0] = {2, 3, 0};
  EXPECT_NE(content_hash(other), content_hash(square()));
}

TEST(Submesh, NormalsAreWeightedByAreaAndAlwaysOfUnitLength) {
  // The corner of a box: a large face up, a small one towards x.
  const Submesh corner{{{0, 0, 0}, {0, 2, 0}, {-2, 0, 0}, {0, 0, -1}}, {}, {{0, 1, 2}, {0, 3, 1}}};
  const auto normals = vertex_normals(corner);
  EXPECT_TRUE(normals[2].isApprox(Eigen::Vector3f{0, 0, 1}));
  EXPECT_TRUE(normals[3].isApprox(Eigen::Vector3f{1, 0, 0}));
  EXPECT_TRUE(normals[0].isApprox(Eigen::Vector3f{1, 0, 2}.normalized()));
}

TEST(Submesh, AVertexWithoutAreaPointsUp) {
  const Submesh line{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {}, {{0, 1, 2}}};
  for (const auto& normal : vertex_normals(line)) EXPECT_EQ(normal, Eigen::Vector3f::UnitZ());
}

}  // namespace
}  // namespace meshloop
