#include "common/gpu/screen_area.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

constexpr double kNear_m = 0.05;
const Camera kCamera{640, 480, 500, 500, 320, 240, {}};

std::vector<Eigen::Vector3d> square(double x, double y, double z, double half) {
  return {{x - half, y - half, z}, {x + half, y - half, z}, {x + half, y + half, z}, {x - half, y + half, z}};
}

TEST(ScreenArea, HoldsTheHullAndAMarginOfTwoPixels) {
  const auto area = area_of_hull(square(0, 0.1, 1, 0.02), kCamera, Pose::Identity(), kNear_m);
  EXPECT_EQ(area, (ScreenArea{308, 278, 25, 25}));
}

TEST(ScreenArea, EndsWithThePicture) {
  const auto area = area_of_hull(square(-0.6, 0, 1, 0.1), kCamera, Pose::Identity(), kNear_m);
  EXPECT_EQ(area, (ScreenArea{0, 188, 73, 105}));
  const auto all = area_of_hull(square(0, 0, 1, 9), kCamera, Pose::Identity(), kNear_m);
  EXPECT_EQ(all, (ScreenArea{0, 0, 640, 480}));
}

TEST(ScreenArea, IsEmptyBesideThePicture) {
  for (const double away : {-3.0, 3.0}) {
    EXPECT_TRUE(area_of_hull(square(away, 0, 1, 0.1), kCamera, Pose::Identity(), kNear_m).empty());
    EXPECT_TRUE(area_of_hull(square(0, away, 1, 0.1), kCamera, Pose::Identity(), kNear_m).empty());
  }
  EXPECT_TRUE(area_of_hull({}, kCamera, Pose::Identity(), kNear_m).empty());
}

TEST(ScreenArea, IsThePictureWhenTheHullReachesBehindTheCamera) {
  auto corners = square(0, 0, 1, 0.1);
  corners.emplace_back(0, 0, -1);
  EXPECT_EQ(area_of_hull(corners, kCamera, Pose::Identity(), kNear_m), (ScreenArea{0, 0, 640, 480}));
}

TEST(ScreenArea, JoinsWithoutRegardToEmptyOnes) {
  const ScreenArea a{10, 20, 5, 5};
  EXPECT_EQ(joined(a, {}), a);
  EXPECT_EQ(joined({}, a), a);
  EXPECT_EQ(joined(a, {30, 10, 2, 2}), (ScreenArea{10, 10, 22, 15}));
}

}  // namespace
}  // namespace meshloop
