#include "server/show/surface_blocks.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <vector>

namespace meshloop {
namespace {

using show::Block;
using show::BlockRules;
using show::make_blocks;

BlockRules rules(float flatness_per_m = 0.01f) {
  return {{64, 48, 60, 60, 31.5, 23.5, {}}, SensorModel{SensorModel::Kind::constant, 0.001}, flatness_per_m};
}

// How many blocks each pixel lies in.
Image<int> cover_of(const std::vector<Block>& blocks, int width, int height) {
  Image<int> cover{width, height};
  for (const Block& block : blocks) {
    for (int y = block.y; y < block.y + block.size; ++y) {
      for (int x = block.x; x < block.x + block.size; ++x) ++cover(x, y);
    }
  }
  return cover;
}

// Inverse depth of a slanted plane.
float plane_at(double u, double v) {
  return static_cast<float>(0.6 + 0.002 * u - 0.001 * v);
}

DepthImage plane(int width, int height) {
  DepthImage depth{width, height};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) depth(x, y) = 1 / plane_at(x, y);
  }
  return depth;
}

TEST(SurfaceBlocks, CoverEachPixelThatHasADepthOnce) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  DepthImage depth = plane(61, 45);
  for (int i = 0; i < 40; ++i) depth(i * 37 % 61, i * 29 % 45) = i % 3 == 0 ? kNaN : i % 3 == 1 ? -1.0f : 0.0f;
  for (int y = 20; y < 27; ++y) {
    for (int x = 30; x < 47; ++x) depth(x, y) = 0.9f;
  }
  const auto cover = cover_of(make_blocks(depth, rules()), 61, 45);
  for (int y = 0; y < 45; ++y) {
    for (int x = 0; x < 61; ++x) EXPECT_EQ(cover(x, y), depth(x, y) > 0 ? 1 : 0) << x << ", " << y;
  }
}

TEST(SurfaceBlocks, APlaneIsTheLargestBlocksAndTheyMeetOnIt) {
  const auto blocks = make_blocks(plane(64, 48), rules());
  EXPECT_EQ(blocks.size(), 48u);
  for (const Block& block : blocks) {
    EXPECT_EQ(block.size, 8);
    if (block.x == 0 || block.y == 0 || block.x == 56 || block.y == 40) continue;  // nothing continues at the rim
    EXPECT_NEAR(block.inverse_depth[0], plane_at(block.x - 0.5, block.y - 0.5), 1e-5);
    EXPECT_NEAR(block.inverse_depth[1], plane_at(block.x + 7.5, block.y - 0.5), 1e-5);
    EXPECT_NEAR(block.inverse_depth[2], plane_at(block.x - 0.5, block.y + 7.5), 1e-5);
    EXPECT_NEAR(block.inverse_depth[3], plane_at(block.x + 7.5, block.y + 7.5), 1e-5);
  }
}

TEST(SurfaceBlocks, NoneReachesOverADepthEdge) {
  DepthImage depth{64, 48, 2.0f};
  for (int y = 11; y < 48; ++y) {
    for (int x = 21; x < 64; ++x) depth(x, y) = 1.2f;
  }
  for (const Block& block : make_blocks(depth, rules(1.0f))) {
    const float first = depth(block.x, block.y);
    EXPECT_EQ(depth(block.x + block.size - 1, block.y + block.size - 1), first);
    for (const float corner : block.inverse_depth) EXPECT_FLOAT_EQ(corner, 1 / first);
  }
}

TEST(SurfaceBlocks, CurvedSurfacesAreCutUntilTheyAreFlatEnough) {
  DepthImage depth{64, 48};
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) depth(x, y) = 1 / (0.5f + 0.0008f * static_cast<float>((x - 32) * (x - 32)));
  }
  const auto fine = make_blocks(depth, {rules().camera, SensorModel{SensorModel::Kind::constant, 1e-5}, 0.002f});
  const auto coarse = make_blocks(depth, {rules().camera, SensorModel{SensorModel::Kind::constant, 1e-5}, 0.02f});
  EXPECT_GT(fine.size(), 2 * coarse.size());
  for (const Block& block : fine) {
    const float left = block.inverse_depth[0];
    const float across = block.inverse_depth[1] - left;
    for (int x = 0; x < block.size && block.size > 1; ++x) {
      const float share = (static_cast<float>(x) + 0.5f) / static_cast<float>(block.size);
      EXPECT_NEAR(left + across * share, 1 / depth(block.x + x, block.y), 0.00201) << block.size;
    }
  }
}

TEST(SurfaceBlocks, ASensorsNoiseDoesNotCutAPlane) {
  const SensorModel kinect;
  DepthImage depth{640, 480};
  std::uint32_t state = 1;
  for (float& z : depth.pixels()) {
    double noise = -6;  // the sum of twelve is nearly normal
    for (int i = 0; i < 12; ++i)
      noise += static_cast<double>((state = state * 1664525u + 1013904223u) >> 8) / (1 << 24);
    z = static_cast<float>(2.5 + noise * kinect.sigma_z_m(2.5, 0));
  }
  const auto blocks = make_blocks(depth, {{640, 480, 585, 585, 319.5, 239.5, {}}, kinect, 0.0f});
  EXPECT_LT(blocks.size(), 2 * 80u * 60u);
}

}  // namespace
}  // namespace meshloop
