// Payloads as a damaged or hostile peer could send them.
#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "common/codec/draco_header.h"
#include "common/codec/draco_part.h"
#include "common/codec/mesh_codec.h"
#include "meshes.h"

namespace meshloop {
namespace {

using test::depth_grid;
using test::faces_of;

std::vector<std::byte> good_bytes() {
  return encode(depth_grid(40, 30)).value();
}

std::string refusal(const std::vector<std::byte>& bytes, const DecodeLimits& limits = {}) {
  const auto decoded = decode(bytes, limits);
  return decoded ? std::string{} : decoded.error().message;
}

/// A header that claims what the arguments say, followed by nothing of use.
std::vector<std::byte> claim(std::uint64_t vertices, std::uint64_t faces, std::uint64_t symbols, std::uint64_t splits) {
  std::vector<std::byte> bytes;
  for (const char value : {'D', 'R', 'A', 'C', 'O', '\2', '\2', '\1', '\1', '\0', '\0', '\0'}) {
    bytes.push_back(static_cast<std::byte>(value));
  }
  const auto add = [&bytes](std::uint64_t value) {
    for (; value > 127; value >>= 7) bytes.push_back(static_cast<std::byte>(value | 0x80));
    bytes.push_back(static_cast<std::byte>(value));
  };
  add(vertices);
  add(faces);
  bytes.push_back(std::byte{0});
  add(symbols);
  add(splits);
  bytes.resize(bytes.size() + 64);
  return bytes;
}

// In the colours after it a cut is found by the payload's hash only.
TEST(HostileBytes, EveryTruncationOfTrianglesAndPositionsIsRefused) {
  const auto bytes = encode(depth_grid(14, 10)).value();
  const std::size_t part = read_draco_part(bytes).value().bytes;
  ASSERT_LT(part, bytes.size());
  for (std::size_t size = 0; size <= part; ++size) {
    const auto message = refusal({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_FALSE(message.empty()) << "the first " << size << " of " << bytes.size() << " bytes were accepted";
  }
}

TEST(HostileBytes, BytesAfterTheMeshAreRefused) {
  auto bytes = good_bytes();
  bytes.push_back(std::byte{0});
  EXPECT_NE(refusal(bytes).find("follow"), std::string::npos) << refusal(bytes);
}

TEST(HostileBytes, OtherFormatsAreNamed) {
  const auto with = [](std::size_t index, int value) {
    auto bytes = good_bytes();
    bytes[index] = static_cast<std::byte>(value);
    return refusal(bytes);
  };
  EXPECT_EQ(refusal({}), "the payload is not Draco");
  EXPECT_EQ(with(0, 'd'), "the payload is not Draco");
  EXPECT_NE(with(5, 1).find("bitstream"), std::string::npos);
  EXPECT_NE(with(7, 0).find("not an Edgebreaker mesh"), std::string::npos);  // a point cloud
  EXPECT_NE(with(8, 0).find("not an Edgebreaker mesh"), std::string::npos);  // sequential
  EXPECT_NE(with(10, 0x80).find("metadata"), std::string::npos);
  EXPECT_NE(with(11, 1).find("traversal"), std::string::npos);
}

TEST(HostileBytes, LimitsHoldBeforeDecoding) {
  const auto bytes = good_bytes();
  EXPECT_NE(refusal(bytes, {.max_bytes = bytes.size() - 1}).find("bytes"), std::string::npos);
  EXPECT_NE(refusal(bytes, {.max_vertices = 1199}).find("claims 1228 vertices"), std::string::npos);
  EXPECT_NE(refusal(bytes, {.max_vertices = 1227}).find("claims 1228 vertices"), std::string::npos);
  EXPECT_NE(refusal(bytes, {.max_triangles = 2261}).find("2262 triangles"), std::string::npos);
  EXPECT_EQ(refusal(bytes, {.max_bytes = bytes.size(), .max_vertices = 1228, .max_triangles = 2262}), "");
}

TEST(HostileBytes, LargeClaimsInShortPayloadsCostNothing) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_NE(refusal(claim(1'900'000, 3'900'000, 3'900'000, 0)).find("more triangles than its bytes"),
            std::string::npos);
  EXPECT_FALSE(refusal(claim(0xffffffff, 0xffffffff, 1, 0)).empty());
  EXPECT_FALSE(refusal(claim(30, 10, 10, 0)).empty());
  EXPECT_NE(refusal(claim(31, 10, 10, 0)).find("contradict"), std::string::npos);
  EXPECT_NE(refusal(claim(12, 10, 11, 0)).find("contradict"), std::string::npos);
  EXPECT_NE(refusal(claim(12, 10, 10, 11)).find("contradict"), std::string::npos);
  EXPECT_NE(refusal(claim(3, 0, 0, 0)).find("contradict"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST(HostileBytes, SplitsCountAsVertices) {
  EXPECT_NE(refusal(claim(1'000'000, 3'900'000, 3'900'000, 1'000'001)).find("claims 2000001 vertices"),
            std::string::npos);
  EXPECT_NE(refusal(claim(1'000'000, 3'900'000, 3'900'000, 1'000'000)).find("more triangles than its bytes"),
            std::string::npos);
  EXPECT_NE(refusal(claim(12, 2'100'000, 2'100'000, 2'100'000)).find("vertices"), std::string::npos);
}

TEST(HostileBytes, SeamsAreRefused) {
  for (const int speed : {0, 2, 5, 10}) {
    auto bytes = encode(depth_grid(40, 30), {speed}).value();
    constexpr std::size_t kConnectivities = 16;  // after the header, the traversal and two counts of two bytes
    ASSERT_EQ(bytes[kConnectivities], std::byte{0});
    bytes[kConnectivities] = std::byte{1};
    EXPECT_NE(refusal(bytes).find("seams"), std::string::npos) << refusal(bytes);
  }
}

/// The payload with a few bytes changed, in one of the ways in which bytes go wrong.
std::vector<std::byte> damaged(std::vector<std::byte> bytes, std::mt19937& random) {
  const auto any = [&random](std::size_t count) { return random() % count; };
  const auto kind = any(4);
  const std::size_t reach = kind == 0 ? 64 : bytes.size();
  for (std::size_t i = 0, count = 1 + any(4); i < count; ++i) {
    bytes[12 + any(std::min(reach, bytes.size()) - 12)] = static_cast<std::byte>(random());
  }
  if (kind == 2) bytes.resize(12 + any(bytes.size() - 12));
  if (kind == 3) std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(any(bytes.size() - 8)), 8, std::byte{0xff});
  return bytes;
}

TEST(HostileBytes, RandomDamageEndsInAnErrorOrAValidMesh) {
  constexpr DecodeLimits kLimits{.max_vertices = 500};  // the grid's 432, and what its splits take
  std::mt19937 random{11};
  auto small = depth_grid(24, 18);
  std::vector<std::vector<std::byte>> seeds;
  for (const int speed : {0, 2, 5, 10}) seeds.push_back(encode(small, {speed}).value());
  small.colors.clear();
  for (const int speed : {0, 2, 5, 10}) seeds.push_back(encode(small, {speed}).value());
  int refused = 0;
  for (int round = 0; round < 4000; ++round) {
    const auto decoded = decode(damaged(seeds[random() % seeds.size()], random), kLimits);
    if (!decoded) {
      ++refused;
      EXPECT_FALSE(decoded.error().message.empty());
      continue;
    }
    ASSERT_LE(decoded->positions.size(), kLimits.max_vertices);
    ASSERT_TRUE(validate(*decoded));
    ASSERT_TRUE(is_on_lattice(*decoded));
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace meshloop
