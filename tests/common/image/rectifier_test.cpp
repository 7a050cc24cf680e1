#include "common/image/rectifier.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "test_images.h"

namespace meshloop {
namespace {

Camera bent_camera() {
  return {160, 120, 140, 141, 80.3, 59.1, {-0.2, 0.05, 0.001, -0.002, 0.01}};
}

// What a lens makes of the pattern 100 + 80 sin(x / 9) sin(y / 7): the ideal position of each distorted pixel is found
// by iteration, which the rectifier does not use.
double pattern(const Eigen::Vector2d& p) {
  return 100 + 80 * std::sin(p.x() / 9) * std::sin(p.y() / 7);
}

Eigen::Vector2d undistorted(const Camera& camera, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < 100; ++i) p += distorted - camera.distort(p);
  return p;
}

TEST(Rectifier, GivesThePinholesPictureWithinInterpolation) {
  const Camera camera = bent_camera();
  ColorImage seen{camera.width, camera.height};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto value = static_cast<std::uint8_t>(std::lround(pattern(undistorted(camera, Eigen::Vector2d(x, y)))));
      seen(x, y) = {value, value, value};
    }
  }
  const ColorImage ideal = Rectifier{camera}.rectify(seen);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (!camera.contains(camera.distort(Eigen::Vector2d(x, y)), 1)) continue;
      EXPECT_NEAR(ideal(x, y).r, pattern({x, y}), 2.5) << x << " " << y;
    }
  }
}

TEST(Rectifier, DepthIsNeverMixed) {
  const Camera camera = bent_camera();
  DepthImage seen{camera.width, camera.height, 1.0f};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; x += 2) seen(x, y) = 2.0f;
  }
  const DepthImage ideal = Rectifier{camera}.rectify(seen);
  EXPECT_TRUE(std::ranges::all_of(ideal.pixels(), [](float d) { return d == 0 || d == 1 || d == 2; }));
  EXPECT_GT(std::ranges::count(ideal.pixels(), 1.0f), 5000);
  EXPECT_GT(std::ranges::count(ideal.pixels(), 2.0f), 5000);
}

TEST(Rectifier, PixelsFromOutsideAreBlackAndUnmeasured) {
  Camera camera = bent_camera();
  camera.distortion = {0.5, 0, 0, 0, 0};  // pulls the corners from outside
  const Rectifier rectifier{camera};
  EXPECT_EQ(rectifier.rectify(ColorImage{camera.width, camera.height, {9, 9, 9}})(0, 0), Rgb8{});
  const DepthImage depth = rectifier.rectify(DepthImage{camera.width, camera.height, 3});
  EXPECT_EQ(depth(0, 0), 0);
  EXPECT_EQ(depth(80, 60), 3);
}

// Without the limit the formula would turn back and show the picture's middle once more around its rim.
TEST(Rectifier, NothingIsShownTwiceBeyondTheLens) {
  Camera camera = bent_camera();
  camera.distortion = {-0.9, 0, 0, 0, 0};
  const double limit_px = camera.lens_limit() * camera.fx;
  ASSERT_LT(limit_px, 90);
  const DepthImage depth = Rectifier{camera}.rectify(DepthImage{camera.width, camera.height, 3});
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double radius_px = std::hypot(x - camera.cx, (y - camera.cy) * camera.fx / camera.fy);
      EXPECT_EQ(depth(x, y), radius_px <= limit_px ? 3.0f : 0.0f) << x << " " << y;
    }
  }
}

TEST(Rectifier, APerfectLensLeavesEveryBit) {
  const Camera camera = bent_camera().without_distortion();
  const ColorImage color = noisy_gradient(camera.width, camera.height);
  DepthImage depth{camera.width, camera.height, 0.1f};
  depth(3, 4) = std::numeric_limits<float>::denorm_min();
  EXPECT_EQ(Rectifier{camera}.rectify(color), color);
  EXPECT_EQ(Rectifier{camera}.rectify(depth), depth);
}

TEST(Rectifier, AbsurdLensesGiveBlackPixelsAndNoCrash) {
  Camera camera = bent_camera();
  camera.distortion = {1e300, -1e300, 1e308, 1e308, 1e308};
  const ColorImage color = Rectifier{camera}.rectify(ColorImage{camera.width, camera.height, {9, 9, 9}});
  EXPECT_EQ(color(0, 0), Rgb8{});
}

}  // namespace
}  // namespace meshloop
