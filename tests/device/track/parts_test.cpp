// The tracker's parts, each against what it promises.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "device/track/absolute_match.h"
#include "device/track/local_contrast.h"
#include "device/track/rendered_view.h"

namespace meshloop {
namespace {

GreyImage waves(int width, int height, double gain, double offset) {
  GreyImage image{width, height};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double wave = std::sin(x * 0.31 + y * 0.07) + std::cos(y * 0.23 - x * 0.05);
      image(x, y) = static_cast<std::uint8_t>(std::lround(offset + gain * wave));
    }
  }
  return image;
}

/// A plane z = 1 + slope * x, as depth.
DepthImage slanted(double slope) {
  DepthImage depth{64, 48};
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) depth(x, y) = static_cast<float>(1 / (1 - slope * (x - 31.5) / 60));
  }
  return depth;
}

RenderedView view_of(DepthImage depth) {
  RenderedView view;
  view.camera = {64, 48, 60, 60, 31.5, 23.5, {}};
  view.depth = std::move(depth);
  return view;
}

TEST(LocalContrast, ForgetsGainAndOffset) {
  const GreyImage bright = local_contrast(waves(80, 60, 50, 128), {}, {31, 0});
  const GreyImage dim = local_contrast(waves(80, 60, 20, 70), {}, {31, 0});
  for (int y = 2; y < 58; ++y) {
    for (int x = 2; x < 78; ++x) EXPECT_NEAR(bright(x, y), dim(x, y), 4) << x << ' ' << y;
  }
}

TEST(LocalContrast, DoesNotBlowUpAFlatPicture) {
  GreyImage flat{40, 40, 90};
  flat(20, 20) = 91;
  const GreyImage contrast = local_contrast(flat, {}, {});
  for (const auto value : contrast.pixels()) EXPECT_NEAR(value, 128, 6);
}

TEST(LocalContrast, MaskedPixelsChangeNothing) {
  GreyImage a = waves(60, 40, 40, 128);
  GreyImage b = a;
  GreyImage mask{60, 40, 255};
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 20; ++x) {
      mask(x, y) = 0;
      b(x, y) = 3;
    }
  }
  EXPECT_EQ(local_contrast(a, mask, {}), local_contrast(b, mask, {}));
  EXPECT_EQ(local_contrast(a, mask, {})(5, 20), 128);
}

TEST(LocalContrast, NothingGivesNothing) {
  EXPECT_TRUE(local_contrast({}, {}, {}).empty());
}

TEST(SteadyDepth, IsExactOnASlantedPlaneBetweenPixels) {
  const double slope = 0.6;
  const auto depth = steady_depth(slanted(slope), {20.25, 24.75});
  ASSERT_TRUE(depth);
  EXPECT_NEAR(*depth, 1 / (1 - slope * (20.25 - 31.5) / 60), 1e-6);
}

TEST(SteadyDepth, RefusesEdgesHolesAndTheBorder) {
  DepthImage depth = slanted(0);
  for (int y = 0; y < 48; ++y) {
    for (int x = 40; x < 64; ++x) depth(x, y) = 1.2f;
  }
  depth(10, 10) = 0;
  EXPECT_FALSE(steady_depth(depth, {39, 24}));
  EXPECT_FALSE(steady_depth(depth, {41.4, 24}));
  EXPECT_TRUE(steady_depth(depth, {36, 24}));
  EXPECT_TRUE(steady_depth(depth, {44, 24}));
  EXPECT_FALSE(steady_depth(depth, {11, 11}));
  EXPECT_FALSE(steady_depth(depth, {1, 24}));
  EXPECT_FALSE(steady_depth(depth, {-5, 24}));
  EXPECT_FALSE(steady_depth(depth, {1e12, 24}));
  EXPECT_FALSE(steady_depth(depth, {std::numeric_limits<double>::quiet_NaN(), 24}));
}

TEST(PixelInView, FindsWhatAnotherPoseSees) {
  const RenderedView view = view_of(slanted(0.4));
  Twist small;
  small << 0.01, -0.008, 0.006, 0.004, -0.005, 0.01;
  const Pose T_other_world = exp(small);
  const Eigen::Vector2d shown{25.3, 20.6};
  const auto point = world_point(view, shown);
  ASSERT_TRUE(point);
  const auto found = pixel_in_view(view, T_other_world, view.camera.project(T_other_world * *point));
  ASSERT_TRUE(found);
  EXPECT_NEAR((*found - shown).norm(), 0, 0.01);
}

TEST(PatchSimilarity, TellsTheSameFromTheOther) {
  const GreyImage image = waves(60, 60, 40, 128);
  const GreyImage brighter = waves(60, 60, 20, 160);
  EXPECT_NEAR(patch_similarity(image, {30.5, 30.5}, brighter, {30.5, 30.5}, 6), 1, 0.01);
  EXPECT_LT(patch_similarity(image, {30, 30}, image, {40, 30}, 6), 0.3);
  EXPECT_EQ(patch_similarity(image, {2, 30}, image, {30, 30}, 6), 0);
  EXPECT_EQ(patch_similarity(GreyImage(60, 60, 7), {30, 30}, image, {30, 30}, 6), 0);
}

TEST(CornerMask, KeepsAwayFromTheOutline) {
  RenderedView view = view_of(slanted(0));
  view.colored = GreyImage{64, 48};
  for (int y = 10; y < 40; ++y) {
    for (int x = 10; x < 50; ++x) view.colored(x, y) = 255;
  }
  const GreyImage mask = corner_mask(view, 5);
  EXPECT_EQ(mask(14, 25), 0);
  EXPECT_EQ(mask(15, 25), 255);
  EXPECT_EQ(mask(44, 25), 255);
  EXPECT_EQ(mask(45, 25), 0);
}

}  // namespace
}  // namespace meshloop
