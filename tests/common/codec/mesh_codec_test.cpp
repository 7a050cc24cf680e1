#include "common/codec/mesh_codec.h"

#include <gtest/gtest.h>

#include <random>

#include "common/codec/color_transform.h"
#include "common/codec/draco_header.h"
#include "meshes.h"

namespace meshloop {
namespace {

using test::depth_grid;
using test::faces_of;
using test::strip;

void expect_same_faces_after_round_trip(const Submesh& submesh, int speed = EncodeOptions{}.speed) {
  const auto bytes = encode(submesh, {speed});
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto decoded = decode(*bytes);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->has_colors(), submesh.has_colors());
  EXPECT_EQ(decoded->triangles.size(), submesh.triangles.size());
  EXPECT_TRUE(faces_of(*decoded) == faces_of(submesh)) << "speed " << speed;
}

TEST(MeshCodec, KeepsEveryTriangleOfADepthGridExactlyAtEverySpeed) {
  const auto grid = depth_grid(80, 60);
  for (int speed = 0; speed <= 10; ++speed) expect_same_faces_after_round_trip(grid, speed);
}

TEST(MeshCodec, SendsCoarserPositionsAndColorsExactlyAndWithFewerBytes) {
  const auto fine = depth_grid(80, 60);
  auto coarse_colors = fine;
  for (auto& color : coarse_colors.colors) {
    for (auto* channel : {&color.r, &color.g, &color.b}) {
      *channel = static_cast<std::uint8_t>(*channel / kCoarseColorStep * kCoarseColorStep);
    }
  }
  const auto bytes_of = [](const Submesh& mesh) { return encode(mesh).value().size(); };
  for (const int coarsening : {2, 4, 8}) {
    expect_same_faces_after_round_trip(snap_to_lattice(fine, coarsening));
    const auto coarse = snap_to_lattice(coarse_colors, coarsening);
    expect_same_faces_after_round_trip(coarse);
    EXPECT_LT(bytes_of(coarse), bytes_of(coarse_colors));
  }
  EXPECT_LT(bytes_of(coarse_colors), 0.85 * static_cast<double>(bytes_of(fine)));
  coarse_colors.colors[7].g |= 1;  // one colour between the steps: all of them keep their lower bits
  expect_same_faces_after_round_trip(coarse_colors);
}

TEST(MeshCodec, KeepsExactPositionsFarFromTheOrigin) {
  auto grid = depth_grid(30, 20);
  for (auto& p : grid.positions) p += Eigen::Vector3f(-731.25f, 1024, 3.5f);
  ASSERT_TRUE(is_on_lattice(grid));
  expect_same_faces_after_round_trip(grid);
}

TEST(MeshCodec, KeepsSeveralComponentsAndDuplicateVertices) {
  auto mesh = depth_grid(12, 9);
  const auto first = mesh;
  for (const auto& triangle : first.triangles) {
    const auto shift = static_cast<std::uint32_t>(first.positions.size());
    mesh.triangles.push_back({triangle[0] + shift, triangle[1] + shift, triangle[2] + shift});
  }
  mesh.positions.insert(mesh.positions.end(), first.positions.begin(), first.positions.end());
  mesh.colors.insert(mesh.colors.end(), first.colors.begin(), first.colors.end());
  expect_same_faces_after_round_trip(mesh);
}

TEST(MeshCodec, KeepsNonManifoldFansRepeatedAndTurnedTriangles) {
  Submesh mesh = strip(3);
  mesh.positions.emplace_back(0.5f, 0.0f, 0.25f);
  mesh.positions.emplace_back(0.5f, 0.0f, -0.25f);
  mesh.triangles.push_back({2, 3, 8});  // a third and a fourth triangle on the edge 2-3
  mesh.triangles.push_back({2, 3, 9});
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.triangles.push_back({mesh.triangles[0][1], mesh.triangles[0][0], mesh.triangles[0][2]});
  mesh.positions.emplace_back(-1.0f, -1.0f, 0.0f);
  mesh.positions.emplace_back(-1.0f, -2.0f, 0.0f);
  mesh.triangles.push_back({0, 10, 11});  // touches the strip in one vertex only
  for (int speed = 0; speed <= 10; ++speed) expect_same_faces_after_round_trip(mesh, speed);
}

TEST(MeshCodec, KeepsTrianglesThatNameAVertexTwice) {
  Submesh mesh = strip(1);
  mesh.triangles.push_back({1, 1, 2});
  mesh.triangles.push_back({0, 3, 0});
  mesh.triangles.push_back({2, 2, 2});
  expect_same_faces_after_round_trip(mesh);
  Submesh one_point{{{0.5f, 0.5f, 0.5f}}, {{1, 2, 3}}, {{0, 0, 0}}};
  expect_same_faces_after_round_trip(one_point);
}

TEST(MeshCodec, KeepsRandomTriangleSoupWithRandomColors) {
  std::mt19937 random{3};
  Submesh soup;
  for (int i = 0; i < 60; ++i) {
    const auto step = [&] { return static_cast<float>(static_cast<int>(random() % 64)) * kLatticeSpacing_m; };
    soup.positions.emplace_back(step(), step(), step());
    const auto channel = [&] { return static_cast<std::uint8_t>(random()); };
    soup.colors.push_back({channel(), channel(), channel()});
  }
  for (int i = 0; i < 400; ++i) {
    const auto index = [&] { return static_cast<std::uint32_t>(random() % soup.positions.size()); };
    soup.triangles.push_back({index(), index(), index()});
  }
  for (int speed = 0; speed <= 10; ++speed) expect_same_faces_after_round_trip(soup, speed);
}

TEST(MeshCodec, DropsOnlyVerticesThatNothingUses) {
  Submesh mesh = strip(2);
  const auto used = mesh.positions.size();
  mesh.positions.emplace_back(9.0f, 9.0f, 9.0f);
  const auto decoded = decode(encode(mesh).value());
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_EQ(decoded->positions.size(), used);
  EXPECT_EQ(faces_of(*decoded), faces_of(mesh));
}

TEST(MeshCodec, EncodesWhatItDecodedWithoutChange) {
  const auto once = decode(encode(depth_grid(40, 30)).value()).value();
  const auto twice = decode(encode(once).value()).value();
  EXPECT_EQ(faces_of(once), faces_of(twice));
}

TEST(MeshCodec, GivesTheSameBytesAndMeshEachTime) {
  const auto grid = depth_grid(40, 30);
  EXPECT_EQ(encode(grid).value(), encode(grid).value());
  const auto bytes = encode(grid).value();
  EXPECT_EQ(content_hash(decode(bytes).value()), content_hash(decode(bytes).value()));
}

TEST(MeshCodec, NeedsATenthOfTheRawBytesForANoisyDepthGrid) {
  const auto grid = depth_grid(320, 240);
  const auto bytes = encode(grid);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_LT(10 * bytes->size(), grid.raw_bytes());
}

TEST(MeshCodec, WritesSmallMeshesWithTheShorterTraversal) {
  const auto is_valence = [](const Submesh& mesh, int speed) {
    return encode(mesh, {speed}).value()[11] == std::byte{2};  // the traversal follows after the header
  };
  EXPECT_FALSE(is_valence(depth_grid(4, 4), 2));
  EXPECT_TRUE(is_valence(depth_grid(20, 20), 2));
  EXPECT_TRUE(is_valence(depth_grid(40, 30), 2));
  EXPECT_FALSE(is_valence(depth_grid(20, 20), 5));
  EXPECT_FALSE(is_valence(depth_grid(40, 30), 5));
}

TEST(MeshCodec, StaysAboveTheLeastBytesATriangleForRegularMeshes) {
  const auto flat = strip(60'000, kLatticeSpacing_m);
  const auto bytes = encode(flat);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_LE(flat.triangles.size(), kMaxTrianglesPerByte * bytes->size());
  expect_same_faces_after_round_trip(flat);
}

TEST(MeshCodec, RefusesPositionsOffTheLattice) {
  Submesh mesh = strip(2);
  mesh.positions[3].x() += kLatticeSpacing_m / 4;
  const auto bytes = encode(mesh);
  ASSERT_FALSE(bytes);
  EXPECT_NE(bytes.error().message.find("lattice"), std::string::npos) << bytes.error().message;
}

TEST(MeshCodec, EncodesTheWidestExtentExactlyAndRefusesOneStepMore) {
  constexpr float kWidest = 8'388'607 * kLatticeSpacing_m;
  Submesh mesh{{{0, 0, 0}, {kWidest, 0, 0}, {kWidest - kLatticeSpacing_m, kLatticeSpacing_m, 0}}, {}, {{0, 1, 2}}};
  expect_same_faces_after_round_trip(mesh);
  mesh.positions[1].x() += kLatticeSpacing_m;
  const auto bytes = encode(mesh);
  ASSERT_FALSE(bytes);
  EXPECT_NE(bytes.error().message.find("split it"), std::string::npos) << bytes.error().message;
}

TEST(MeshCodec, RefusesToEncodeInvalidMeshes) {
  EXPECT_FALSE(encode(Submesh{}));
  Submesh out_of_range = strip(1);
  out_of_range.triangles[0][1] = 99;
  EXPECT_FALSE(encode(out_of_range));
  Submesh not_finite = strip(1);
  not_finite.positions[0].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(encode(not_finite));
}

void expect_reversible(const Rgb8& color, int step) {
  ASSERT_EQ(from_coded(to_coded(color, step), step), color);
}

TEST(ColorTransform, IsReversibleForEveryColor) {
  for (int r = 0; r < 256; r += 3) {
    for (int g = 0; g < 256; ++g) {
      for (int b = 0; b < 256; b += 5) {
        const Rgb8 color{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)};
        expect_reversible(color, 1);
        if ((r | g | b) % kCoarseColorStep == 0) expect_reversible(color, kCoarseColorStep);
      }
    }
  }
}

}  // namespace
}  // namespace meshloop
