// Meshes on a coarse lattice whose border lies on the finest one.
#include "common/codec/border_offsets.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "common/codec/mesh_codec.h"
#include "meshes.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using test::depth_grid;
using test::faces_of;

constexpr float kStep_m = kLatticeSpacing_m;

/// Every vertex of the left side, or of all sides, keeps its place on the finest lattice.
Submesh joined_grid(int width, int height, int coarsening, bool all_sides = false) {
  Submesh grid = depth_grid(width, height);
  std::vector<std::uint32_t> joined;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool is_side = x == 0 || (all_sides && (x == width - 1 || y == 0 || y == height - 1));
      if (is_side) joined.push_back(static_cast<std::uint32_t>(y * width + x));
    }
  }
  return snap_to_lattice(std::move(grid), coarsening, joined);
}

void expect_exact_round_trip(const Submesh& submesh, int speed = EncodeOptions{}.speed) {
  const auto bytes = encode(submesh, {speed});
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto decoded = decode(*bytes);
  ASSERT_TRUE(decoded) << decoded.error().message;
  EXPECT_TRUE(faces_of(*decoded) == faces_of(submesh)) << "speed " << speed;
}

TEST(BorderOffsets, BringEveryPositionBackExactly) {
  for (const int coarsening : {2, 4, 8}) {
    for (const bool all_sides : {false, true}) {
      const Submesh grid = joined_grid(40, 30, coarsening, all_sides);
      ASSERT_EQ(coarsening_of(grid), 1);
      ASSERT_EQ(coarsening_inside(grid), coarsening);
      for (const int speed : {0, 1, 2, 5, 10}) expect_exact_round_trip(grid, speed);
    }
  }
}

TEST(BorderOffsets, BringPositionsBackWithoutColorsAndFarFromTheOrigin) {
  Submesh grid = joined_grid(20, 15, 4);
  for (auto& p : grid.positions) p += Eigen::Vector3f(-731.25f, 1024, -1999.5f);
  ASSERT_EQ(coarsening_inside(grid), 4);
  expect_exact_round_trip(grid);
  grid.colors.clear();
  expect_exact_round_trip(grid);
}

TEST(BorderOffsets, BringPositionsBackBesideATexture) {
  Submesh wall = test::textured_wall();
  const auto is_border = border_vertices(wall.triangles, wall.positions.size());
  wall = snap_to_lattice(wall, 8);
  const auto first = std::find(is_border.begin(), is_border.end(), true) - is_border.begin();
  wall.positions[static_cast<std::size_t>(first)].x() += kStep_m;
  expect_exact_round_trip(wall);
  EXPECT_EQ(decode(encode(wall).value())->texture->jpeg, wall.texture->jpeg);
}

// Edges with three triangles, vertices between two fans, turned and repeated triangles: Draco gives these vertices of
// their own, and other ones may then be at a border.
TEST(BorderOffsets, BringSoupBackExactly) {
  std::mt19937 random{5};
  const auto any = [&](std::size_t count) { return static_cast<std::uint32_t>(random() % count); };
  for (int round = 0; round < 200; ++round) {
    Submesh soup = snap_to_lattice(depth_grid(12, 9), 4);
    for (int i = 0; i < 4; ++i) {
      const auto end = soup.positions.size();
      soup.triangles.push_back({any(end), any(end), any(end)});
      soup.triangles.erase(soup.triangles.begin() + any(soup.triangles.size()));
    }
    const auto is_border = border_vertices(soup.triangles, soup.positions.size());
    for (std::size_t i = 0; i < soup.positions.size(); ++i) {
      if (is_border[i] && any(2) == 0) soup.positions[i].x() += static_cast<float>(any(4)) * kStep_m;
    }
    expect_exact_round_trip(soup);
  }
}

TEST(BorderOffsets, TakeLessThanTheFinestLatticeForAll) {
  struct Case {
    int width, height;
    double share;  // of what the finest lattice takes
  };
  for (const auto& [width, height, share] : {Case{12, 10, 0.85}, Case{40, 30, 0.75}, Case{160, 120, 0.75}}) {
    Submesh grid = joined_grid(width, height, 4);
    Submesh finest = depth_grid(width, height);
    for (auto* mesh : {&grid, &finest}) mesh->colors.clear();
    const auto bytes = encode(grid).value().size();
    const auto whole = encode(finest).value().size();
    fmt::print("{} triangles: {} bytes, all on the finest lattice {}\n", grid.triangles.size(), bytes, whole);
    EXPECT_LT(static_cast<double>(bytes), share * static_cast<double>(whole));
  }
}

TEST(BorderOffsets, AreLeftOutWhereOneLatticeIsNoLonger) {
  EXPECT_EQ(coarsening_inside(depth_grid(20, 20)), 1);
  EXPECT_EQ(coarsening_inside(snap_to_lattice(depth_grid(20, 20), 4)), 1);
  EXPECT_EQ(coarsening_inside(joined_grid(20, 2, 4, true)), 1);
  const auto grid = joined_grid(20, 20, 4);
  auto inside = grid;
  inside.positions[20 * 10 + 10].z() += kStep_m;
  EXPECT_EQ(coarsening_inside(grid), 4);
  EXPECT_LT(coarsening_inside(inside), 4);
  expect_exact_round_trip(inside);
}

TEST(BorderOffsets, TakenFromPositionsAddUpToThem) {
  std::mt19937 random{6};
  for (const int coarsening : {2, 4, 8}) {
    std::vector<Eigen::Vector3f> positions;
    for (int i = 0; i < 3000; ++i) {
      const auto coordinate = [&] {
        const float widest_m = i % 3 == 0 ? 9000 : 2;
        return std::uniform_real_distribution<float>{-widest_m, widest_m}(random);
      };
      positions.push_back(on_lattice({coordinate(), coordinate(), coordinate()}));
    }
    auto coarse = positions;
    const auto offsets = take_offsets(coarse, coarsening);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      ASSERT_TRUE(is_on_lattice(coarse[i], coarsening));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int step = offsets[i][axis];
        ASSERT_TRUE(-coarsening / 2 <= step && step < coarsening / 2) << step;
        ASSERT_EQ(coarse[i][static_cast<Eigen::Index>(axis)] + static_cast<float>(step) * kStep_m,
                  positions[i][static_cast<Eigen::Index>(axis)]);
      }
    }
  }
}

TEST(BorderOffsets, OnlyVerticesWithAGapAroundThemAreAtTheBorder) {
  const auto grid = depth_grid(5, 4);
  const auto is_border = border_vertices(grid.triangles, grid.positions.size());
  for (std::size_t i = 0; i < is_border.size(); ++i) {
    const auto x = i % 5;
    const auto y = i / 5;
    EXPECT_EQ(is_border[i], x == 0 || y == 0 || x == 4 || y == 3) << i;
  }
}

/// Offsets of three vertices, coded and decoded again; what is refused and why, or nothing.
std::string refusal_of(const std::vector<LatticeOffset>& offsets, const Eigen::Vector3f& position) {
  const std::vector<bool> is_border{true, true, false};
  BitEncoder out;
  encode_offsets(out, offsets, is_border, 4);
  const auto bytes = out.finish();
  BitDecoder in{bytes};
  std::vector<Eigen::Vector3f> positions(3, position);
  const auto ok = decode_offsets(in, is_border, 4, positions);
  if (!ok) return ok.error().message;
  EXPECT_TRUE(in.is_at_end());
  const auto& [x, y, z] = offsets[1];
  EXPECT_EQ(positions[1], Eigen::Vector3f(x, y, z) * kStep_m);
  EXPECT_EQ(positions[2], position);
  return {};
}

TEST(BorderOffsets, MoveTheVerticesThatTheyWereWrittenFor) {
  EXPECT_EQ(refusal_of({{}, {1, 0, -2}, {}}, Eigen::Vector3f::Zero()), "");
}

TEST(BorderOffsets, ThatMoveNothingAreRefused) {
  EXPECT_NE(refusal_of({{}, {}, {}}, Eigen::Vector3f::Zero()).find("no vertex"), std::string::npos);
  BitEncoder out;  // one is said to be moved, and is not
  ProbabilityModel is_moved;
  out.encode(is_moved, true);
  for (int axis = 0; axis < 3; ++axis) out.encode_bypass(2, 2);
  const auto bytes = out.finish();
  BitDecoder in{bytes};
  std::vector<Eigen::Vector3f> positions(1, Eigen::Vector3f::Zero());
  const auto ok = decode_offsets(in, {true}, 4, positions);
  ASSERT_FALSE(ok);
  EXPECT_NE(ok.error().message.find("and is not"), std::string::npos) << ok.error().message;
}

TEST(BorderOffsets, OfAnotherLatticeAreRefused) {
  EXPECT_NE(refusal_of({{}, {1, 0, -2}, {}}, {2 * kStep_m, 0, 0}).find("lattice"), std::string::npos);
}

TEST(BorderOffsets, RandomDamageEndsInAnErrorOrAValidMesh) {
  std::mt19937 random{12};
  const auto good = encode(joined_grid(24, 18, 4, true)).value();
  int refused = 0;
  for (int round = 0; round < 2000; ++round) {
    auto bytes = good;
    const std::size_t reach = round % 2 == 0 ? 60 : bytes.size() - 12;  // its end has the offsets
    for (unsigned i = 0; i < 1 + random() % 3; ++i)
      bytes[bytes.size() - 1 - random() % reach] = static_cast<std::byte>(random());
    if (round % 5 == 0) bytes.resize(bytes.size() - random() % 60);
    const auto decoded = decode(bytes);
    refused += decoded ? 0 : 1;
    if (!decoded) continue;
    ASSERT_TRUE(validate(*decoded));
    ASSERT_TRUE(is_on_lattice(*decoded));
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace meshloop
