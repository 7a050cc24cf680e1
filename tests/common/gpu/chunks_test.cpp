#include "common/gpu/chunks.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace meshloop {
namespace {

TEST(Chunks, HoldEachTriangleOnceWithinTheirBounds) {
  Submesh submesh;
  constexpr std::uint32_t kCells = 80;
  for (std::uint32_t i = 0; i <= kCells; ++i) {
    for (std::uint32_t j = 0; j <= kCells; ++j) {
      submesh.positions.emplace_back(static_cast<float>(i), static_cast<float>(j), 0.0F);
      if (i == kCells || j == kCells) continue;
      const std::uint32_t here = i * (kCells + 1) + j;
      submesh.triangles.push_back({here, here + 1, here + kCells + 1});
      submesh.triangles.push_back({here + 1, here + kCells + 2, here + kCells + 1});
    }
  }
  const auto chunked = make_chunks(submesh);
  auto sorted = chunked.triangles;
  auto expected = submesh.triangles;
  std::sort(sorted.begin(), sorted.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(sorted, expected);
  int next = 0;
  float area = 0;
  for (const auto& chunk : chunked.chunks) {
    EXPECT_EQ(chunk.first_index, next);
    next += chunk.index_count;
    area += chunk.bounds.sizes().x() * chunk.bounds.sizes().y();
    for (int i = chunk.first_index / 3; i < next / 3; ++i) {
      for (const auto vertex : chunked.triangles[static_cast<std::size_t>(i)]) {
        EXPECT_TRUE(chunk.bounds.contains(submesh.positions[vertex]));
      }
    }
  }
  EXPECT_EQ(next, static_cast<int>(3 * submesh.triangles.size()));
  // Near each other: 25 boxes of triangles from anywhere would cover the whole 25 times.
  EXPECT_EQ(chunked.chunks.size(), 25U);
  EXPECT_LT(area, 3.0F * kCells * kCells);
}

TEST(Chunks, OfNothingAreNone) {
  const auto chunked = make_chunks({});
  EXPECT_TRUE(chunked.triangles.empty());
  EXPECT_TRUE(chunked.chunks.empty());
}

}  // namespace
}  // namespace meshloop
