#include "common/codec/mesh_tail.h"

#include <gtest/gtest.h>

#include <random>

#include "common/codec/color_coder.h"
#include "common/codec/mesh_codec.h"
#include "meshes.h"

namespace meshloop {
namespace {

using Bytes = std::vector<std::byte>;

std::string refusal(const Bytes& tail) {
  Submesh mesh = test::strip(3);
  const auto ok = read_mesh_tail(tail, mesh);
  return ok ? std::string{} : ok.error().message;
}

TEST(MeshTail, OfNothingIsOneByte) {
  EXPECT_EQ(write_mesh_tail({}, {}), Bytes{std::byte{0}});
  EXPECT_EQ(refusal({std::byte{0}}), "");
}

TEST(MeshTail, IsRefusedWhenItIsMissingOrUnknown) {
  EXPECT_NE(refusal({}).find("ends"), std::string::npos);
  for (const int what : {3, 7, 16, 64, 128}) {
    EXPECT_NE(refusal({static_cast<std::byte>(what), std::byte{0}}).find("unknown"), std::string::npos) << what;
  }
}

/// Of the eight vertices of a strip.
Bytes colors_and_offsets() {
  MeshTail tail;
  for (int i = 0; i < 8; ++i) tail.colors.push_back({static_cast<std::uint8_t>(31 * i), 7, 9});
  tail.coarsening = 4;
  tail.offsets.resize(8);
  tail.offsets[5] = {1, -2, 0};
  return write_mesh_tail(tail, std::vector<bool>(8, true));
}

TEST(MeshTail, IsRefusedWhenItGoesOn) {
  const auto bytes = colors_and_offsets();
  ASSERT_EQ(refusal(bytes), "");
  for (std::size_t more = 1; more < 20; ++more) {
    auto longer = bytes;
    longer.resize(bytes.size() + more, std::byte{0});
    EXPECT_NE(refusal(longer).find("follow"), std::string::npos) << more << " zeros";
    if (more <= 4) continue;
    longer.back() = std::byte{1};
    EXPECT_NE(refusal(longer).find("follow"), std::string::npos) << more;
  }
}

TEST(MeshTail, IsReadWithinTheMeshWhereverItIsCut) {
  const auto bytes = colors_and_offsets();
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    Submesh mesh = test::strip(3);
    if (!read_mesh_tail(std::span{bytes}.first(size), mesh)) continue;
    EXPECT_EQ(mesh.colors.size(), 8U);
    EXPECT_TRUE(validate(mesh)) << size;
  }
}

TEST(MeshTail, GivesColorsAndOffsetsToTheVerticesTheyWereWrittenFor) {
  Submesh mesh = test::strip(3);
  const auto positions = mesh.positions;
  MeshTail tail;
  for (int i = 0; i < 8; ++i) tail.colors.push_back({static_cast<std::uint8_t>(31 * i), 255, 0});
  tail.coarsening = 8;
  tail.offsets.resize(8);
  tail.offsets[5] = {3, -4, 0};
  ASSERT_TRUE(read_mesh_tail(write_mesh_tail(tail, std::vector<bool>(8, true)), mesh));
  EXPECT_EQ(mesh.colors, tail.colors);
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector3f moved = i == 5 ? Eigen::Vector3f{3, -4, 0} : Eigen::Vector3f::Zero();
    EXPECT_EQ(mesh.positions[i], positions[i] + moved * kLatticeSpacing_m) << i;
  }
}

TEST(ColorCoder, GivesAnyColorsBack) {
  std::mt19937 random{8};
  for (const unsigned step : {1U, static_cast<unsigned>(kCoarseColorStep)}) {
    for (const std::size_t count : {0UL, 1UL, 2UL, 50UL, 20'000UL}) {
      std::vector<Rgb8> colors;
      while (colors.size() < count) {
        const auto channel = [&] { return static_cast<std::uint8_t>(random() % 256 / step * step); };
        colors.push_back({channel(), channel(), channel()});
      }
      BitEncoder out;
      encode_colors(out, colors, static_cast<int>(step));
      const auto bytes = out.finish();
      BitDecoder in{bytes};
      EXPECT_EQ(decode_colors(in, count, static_cast<int>(step)), colors);
      EXPECT_TRUE(in.is_at_end());
    }
  }
}

TEST(ColorCoder, TakesAlmostNothingForOneColor) {
  const std::vector<Rgb8> wall(1000, Rgb8{200, 192, 184});
  BitEncoder out;
  encode_colors(out, wall, kCoarseColorStep);
  EXPECT_LT(out.finish().size(), 40U);
}

TEST(BitCoder, GivesBackBitsOfEveryLikelihood) {
  std::mt19937 random{9};
  for (int round = 0; round < 300; ++round) {
    std::vector<bool> bits;
    const auto ones = static_cast<unsigned>(round) % 101;
    for (std::size_t i = 0; i < static_cast<std::size_t>(round) * 7; ++i) bits.push_back(random() % 100 < ones);
    BitEncoder out;
    ProbabilityModel model;
    for (const bool bit : bits) {
      out.encode(model, bit);
      out.encode_bypass(bit ? 5 : 2, 3);
    }
    const auto bytes = out.finish();
    BitDecoder in{bytes};
    ProbabilityModel again;
    for (const bool bit : bits) {
      ASSERT_EQ(in.decode(again), bit);
      ASSERT_EQ(in.decode_bypass(3), bit ? 5U : 2U);
    }
    EXPECT_TRUE(in.is_at_end());
  }
}

TEST(BitCoder, TakesLittleMoreThanTheEntropy) {
  std::mt19937 random{10};
  BitEncoder out;
  ProbabilityModel model;
  for (int i = 0; i < 80'000; ++i) out.encode(model, random() % 20 == 0);
  EXPECT_LT(static_cast<double>(out.finish().size()), 1.04 * 0.2864 * 10'000);  // H(1/20) is 0.2864 bits
}

}  // namespace
}  // namespace meshloop
