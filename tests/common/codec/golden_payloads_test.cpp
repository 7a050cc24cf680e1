// Payloads as this schema version has them. If one fails, devices of this schema no longer understand stations: raise
// kSchemaVersion (proto/meshloop.idl), and only then write the new bytes here.
#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "common/codec/mesh_codec.h"
#include "meshes.h"

namespace meshloop {
namespace {

using test::faces_of;

constexpr std::string_view kColors =
    "445241434f0202010100000014180018020008effab4aa4fb5aa06ff011101ff000001000903000002010101010525b12a07110169061101"
    "110103250245040b110111010b11012311011b110111160d82089db31c9a2b3522ad2792f32f830000000024000000000000000000000000"
    "00000000007c3c06013fff6227ffff83fffe20ffffe07ffff0600f3f571889c5e1b6be675eedf083c7ac7e6840e169b2d21b5ea8efe5f716"
    "80";
constexpr std::string_view kCoarseColors =
    "445241434f0202010100000014180018020008effab4aa4fb5aa06ff011101ff000001000903000002010101010525b12a07110169061101"
    "110103250245040b110111010b11012311011b110111160d82089db31c9a2b3522ad2792f32f830000000024000000000000000000000000"
    "00000000007c3c0602247e9fb1b1883e4ec09b827ce0da1459c425942f19aa36159585ed4a7087454ae964357ec2fce12a8d390640";
constexpr std::string_view kOffsets =
    "445241434f0202010100000014180018020008effab4aa4fb5aa06ff011101ff000001000903000002010101010525b12a07110169061101"
    "110103250245040b110111010b11012311011b110111160d82089db31c9a2b3522ad2792f32f830000000024000000000000000000000000"
    "00000000007c3d06083f118645";
constexpr std::string_view kTexture =
    "4d545831790000000000484200000000000000000000000000004842000000000000a0400000a0400000803f0000a0400000a0400000803f"
    "445241434f0202010100000014180018020008effab4aa4fb5aa06ff011101ff000001000903000002010101010525b12a07110169061101"
    "110103250245040b110111010b11012311011b110111160d82089db31c9a2b3522ad2792f32f830000000024000000000000000000000000"
    "00000000007c3c0600ffd8ffe000104a46494600010100000100010000ffdb0043000d090a0b0a080d0b0a0b0e0e0d0f1320151312121327"
    "1c1e17202e2931302e292d2c333a4a3e333646372c2d405741464c4e525352323e5a615a50604a51524fffdb0043010e0e0e131113261515"
    "264f352d354f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4f4fff"
    "c20011080001000103011100021101031101ffc40014000100000000000000000000000000000003ffc40015010101000000000000000000"
    "00000000000405ffda000c030100021003100000013151ffc40014100100000000000000000000000000000000ffda00080101000105027f"
    "ffc40014110100000000000000000000000000000000ffda0008010301013f017fffc40014110100000000000000000000000000000000ff"
    "da0008010201013f017fffc40014100100000000000000000000000000000000ffda0008010100063f027fffc40014100100000000000000"
    "000000000000000000ffda0008010100013f217fffda000c03010002000300000010dfffc400141101000000000000000000000000000000"
    "00ffda0008010301013f107fffc40014110100000000000000000000000000000000ffda0008010201013f107fffc4001410010000000000"
    "0000000000000000000000ffda0008010100013f107fffd9";

std::vector<std::byte> bytes_of(std::string_view hex) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(16 * digit(hex[i]) + digit(hex[i + 1])));
  return bytes;
}

/// A bumpy sheet of 4 x 3 squares on the lattice of this coarsening.
Submesh sheet(int coarsening) {
  const float step_m = kLatticeSpacing_m * static_cast<float>(coarsening);
  Submesh mesh;
  for (std::uint32_t y = 0; y < 4; ++y) {
    for (std::uint32_t x = 0; x < 5; ++x) {
      const Eigen::Vector3f steps{static_cast<float>(9 * x), static_cast<float>(7 * y),
                                  static_cast<float>((x * x + 3 * y) % 5)};
      mesh.positions.push_back(steps * step_m);
      const std::uint32_t a = 5 * y + x;
      if (x == 4 || y == 3) continue;
      mesh.triangles.push_back({a, a + 1, a + 5});
      mesh.triangles.push_back({a + 1, a + 6, a + 5});
    }
  }
  return mesh;
}

/// Neighbours are close, but for one in seven that ends in bypass bits.
Submesh colored_sheet(std::uint32_t step) {
  Submesh mesh = sheet(1);
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
    const auto channel = [&](std::uint32_t value) { return static_cast<std::uint8_t>(value * step % 256); };
    const std::uint32_t jump = i % 7 == 6 ? 25 : 0;
    mesh.colors.push_back({channel(20 + i), channel(3 + i / 2 + jump), channel(9 + i % 3)});
  }
  return mesh;
}

/// Three vertices of the border lie beside the coarse lattice.
Submesh joined_sheet() {
  Submesh mesh = sheet(4);
  mesh.positions[0] += Eigen::Vector3f{1, 0, -2} * kLatticeSpacing_m;
  mesh.positions[3] += Eigen::Vector3f{-1, -1, 1} * kLatticeSpacing_m;
  mesh.positions[19] += Eigen::Vector3f{0, 1, 0} * kLatticeSpacing_m;
  return mesh;
}

/// What was decoded, for a look at what only some payloads have.
Submesh expect_decoded(std::string_view hex, const Submesh& expected) {
  const auto decoded = decode(bytes_of(hex));
  if (!decoded) {
    ADD_FAILURE() << decoded.error().message;
    return {};
  }
  EXPECT_EQ(decoded->positions.size(), expected.positions.size());
  EXPECT_EQ(decoded->has_colors(), expected.has_colors());
  EXPECT_TRUE(faces_of(*decoded) == faces_of(expected));
  return *decoded;
}

TEST(GoldenPayloads, OfColorsDecodeExactly) {
  expect_decoded(kColors, colored_sheet(1));
}

TEST(GoldenPayloads, OfColorsInStepsOfEightDecodeExactly) {
  expect_decoded(kCoarseColors, colored_sheet(8));
}

TEST(GoldenPayloads, OfOffsetsAtTheBorderDecodeExactly) {
  expect_decoded(kOffsets, joined_sheet());
}

TEST(GoldenPayloads, OfATextureDecodeExactly) {
  const auto decoded = expect_decoded(kTexture, sheet(1));
  ASSERT_TRUE(decoded.texture);
  TextureProjection projection;
  projection << 50, 0, 5, 5, 0, 50, 5, 5, 0, 0, 1, 1;
  EXPECT_EQ(decoded.texture->projection, projection);
  EXPECT_EQ(decoded.texture->width, 1);
  EXPECT_EQ(decoded.texture->height, 1);
  const auto payload = bytes_of(kTexture);
  const std::vector<std::byte> jpeg{payload.end() - 519, payload.end()};
  EXPECT_EQ(decoded.texture->jpeg, jpeg);
}

}  // namespace
}  // namespace meshloop
