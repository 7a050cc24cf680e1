#include "server/adjust/outline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace meshloop::adjust {
namespace {

double area_of(const Loop& loop) {
  double area = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const auto& a = loop[i];
    const auto& b = loop[(i + 1) % loop.size()];
    area += (a.x() * b.y() - a.y() * b.x()) / 2;
  }
  return area;
}

/// Pixels whose middle lies in a rectangle of 2 * half_width by 2 * half_height around (60, 50), turned.
Image<std::uint8_t> rectangle(double half_width, double half_height, double turn) {
  Image<std::uint8_t> mask{120, 100};
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      const double u = std::cos(turn) * (x - 60) + std::sin(turn) * (y - 50);
      const double v = -std::sin(turn) * (x - 60) + std::cos(turn) * (y - 50);
      mask(x, y) = std::abs(u) <= half_width && std::abs(v) <= half_height ? 1 : 0;
    }
  }
  return mask;
}

TEST(Outline, ARectangleHasFourCornersWhicheverWayItIsTurned) {
  for (const double turn : {0.0, 0.1, 0.3, 0.785, 1.2, 2.0}) {
    const auto mask = rectangle(30.3, 20.4, turn);
    const auto pixels = static_cast<double>(std::count(mask.pixels().begin(), mask.pixels().end(), 1));
    const auto loops = outline_of(mask, 10);
    ASSERT_EQ(loops.size(), 1U);
    EXPECT_LE(loops[0].size(), 6U) << turn;
    EXPECT_NEAR(std::abs(area_of(loops[0])), pixels, 0.015 * pixels) << turn;
  }
}

TEST(Outline, HolesRunTheOtherWayRound) {
  auto mask = rectangle(30, 20, 0.2);
  for (int y = 45; y < 55; ++y) {
    for (int x = 50; x < 60; ++x) mask(x, y) = 0;
  }
  const auto loops = outline_of(mask, 10);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_LT(area_of(loops[0]) * area_of(loops[1]), 0);
  EXPECT_NEAR(std::min(std::abs(area_of(loops[0])), std::abs(area_of(loops[1]))), 100, 3);
}

TEST(Outline, SpecksAndNothingAreLeftOut) {
  Image<std::uint8_t> mask{20, 20};
  EXPECT_TRUE(outline_of(mask, 10).empty());
  mask(3, 3) = mask(4, 3) = mask(9, 9) = mask(10, 10) = 1;
  EXPECT_TRUE(outline_of(mask, 10).empty());
}

TEST(Outline, AWholePictureEndsWithIt) {
  Image<std::uint8_t> mask{20, 10, 1};
  const auto loops = outline_of(mask, 10);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].size(), 4U);
  EXPECT_NEAR(std::abs(area_of(loops[0])), 200, 1e-3);
}

TEST(Outline, LinesAroundAnyPixelsHoldAsMuchAsThem) {
  std::mt19937 random{1};
  for (int i = 0; i < 50; ++i) {
    // Overlapping rectangles.
    Image<std::uint8_t> mask{120, 100};
    for (int k = 0; k < 6; ++k) {
      const int x = static_cast<int>(random() % 80);
      const int y = static_cast<int>(random() % 60);
      const int w = 8 + static_cast<int>(random() % 30);
      const int h = 8 + static_cast<int>(random() % 30);
      for (int v = y; v < y + h; ++v) {
        for (int u = x; u < x + w; ++u) mask(u, v) = 1;
      }
    }
    double area = 0;
    for (const auto& loop : outline_of(mask, 1)) area += area_of(loop);
    const auto pixels = static_cast<double>(std::count(mask.pixels().begin(), mask.pixels().end(), 1));
    EXPECT_NEAR(std::abs(area), pixels, 0.03 * pixels) << i;
  }
}

}  // namespace
}  // namespace meshloop::adjust
