#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/simulation/sensor.h"

namespace meshloop::simulation {
namespace {

const Camera kCamera{160, 120, 140, 140, 79.5, 59.5, {}};

Solid grey_solid(Solid::Shape shape, const Eigen::Vector3d& size, const Eigen::Vector3d& at) {
  Solid solid;
  solid.shape = shape;
  solid.size = size;
  solid.T_world_solid = Pose(Eigen::Translation3d(at));
  solid.texture = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Rgb8{128, 128, 128}; };
  solid.modelled = true;
  solid.object = "thing";
  return solid;
}

Scene scene_of(std::vector<Solid> solids) {
  return {std::move(solids), [](const Eigen::Vector3d&) { return Rgb8{10, 20, 30}; }};
}

TEST(CastDepth, PlaneLiesAtItsDistanceInEveryPixelAndCosThetaIsThatOfTheRay) {
  const Scene scene = scene_of({grey_solid(Solid::Shape::box, {20, 20, 1}, {0, 0, 2.5})});
  const ExactDepth exact = cast_depth(scene, kCamera, Pose::Identity(), false);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      ASSERT_FLOAT_EQ(exact.depth(u, v), 2.0f);
      ASSERT_EQ(exact.solid(u, v), 1);
      ASSERT_NEAR(exact.cos_theta(u, v), 1 / kCamera.back_project(u, v, 1).norm(), 1e-6);
    }
  }
}

TEST(CastDepth, CylinderIsSeenAtTheRootsOfItsEquation) {
  // Its axis is the world's z axis, which the camera sees as its y axis.
  Solid solid = grey_solid(Solid::Shape::cylinder, {1.0, 1.0, 4.0}, {0, 0, 0});
  const Pose T_camera_world = look_at({0, -3, 0}, {0, 0, 0}, Eigen::Vector3d::UnitZ()).inverse();
  const ExactDepth exact = cast_depth(scene_of({solid}), kCamera, T_camera_world, false);
  int seen = 0;
  for (int u = 0; u < kCamera.width; ++u) {
    const double slope = (u - kCamera.cx) / kCamera.fx;
    // Points (slope z, z - 3) with slope^2 z^2 + (z - 3)^2 = 0.25.
    const double a = 1 + slope * slope;
    const double discriminant = 9 - a * (9 - 0.25);
    const float depth = exact.depth(u, 60);
    ASSERT_EQ(depth > 0, discriminant > 0) << "column " << u;
    if (discriminant <= 0) continue;
    ++seen;
    ASSERT_NEAR(depth, (3 - std::sqrt(discriminant)) / a, 1e-6) << "column " << u;
  }
  EXPECT_GT(seen, 40);
}

TEST(CastDepth, NearestSolidWinsWhateverTheOrder) {
  const Solid far = grey_solid(Solid::Shape::box, {4, 4, 1}, {0, 0, 3.5});
  const Solid near = grey_solid(Solid::Shape::box, {0.5, 0.5, 0.2}, {0, 0, 1.6});
  const auto one = cast_depth(scene_of({far, near}), kCamera, Pose::Identity(), false);
  const auto other = cast_depth(scene_of({near, far}), kCamera, Pose::Identity(), false);
  EXPECT_EQ(one.depth, other.depth);
  EXPECT_FLOAT_EQ(one.depth(80, 60), 1.5f);
  EXPECT_FLOAT_EQ(one.depth(5, 60), 3.0f);
  EXPECT_EQ(one.solid(80, 60), 2);
  EXPECT_EQ(other.solid(80, 60), 1);
}

TEST(CastDepth, ModelledOnlyLeavesTheOthersOut) {
  Solid guest = grey_solid(Solid::Shape::box, {0.5, 0.5, 0.2}, {0, 0, 1.6});
  guest.modelled = false;
  const Scene scene = scene_of({grey_solid(Solid::Shape::box, {4, 4, 1}, {0, 0, 3.5}), guest});
  EXPECT_FLOAT_EQ(cast_depth(scene, kCamera, Pose::Identity(), true).depth(80, 60), 3.0f);
  EXPECT_FLOAT_EQ(cast_depth(scene, kCamera, Pose::Identity(), false).depth(80, 60), 1.5f);
}

TEST(CastDepth, SolidsBehindTheCameraOrAroundItAreNotSeen) {
  const Solid behind = grey_solid(Solid::Shape::box, {1, 1, 1}, {0, 0, -3});
  const Solid around = grey_solid(Solid::Shape::box, {1, 1, 1}, {0, 0, 0});
  const ExactDepth exact = cast_depth(scene_of({behind, around}), kCamera, Pose::Identity(), false);
  const auto pixels = exact.depth.pixels();
  EXPECT_TRUE(std::all_of(pixels.begin(), pixels.end(), [](float z) { return z == 0; }));
}

TEST(CastDepth, SolidThatReachesBehindTheCameraIsStillSeenInFront) {
  // A floor 1 m below a camera that looks along it.
  const Scene scene = scene_of({grey_solid(Solid::Shape::box, {20, 0.2, 20}, {0, 1.1, 0})});
  const ExactDepth exact = cast_depth(scene, kCamera, Pose::Identity(), false);
  for (int v = 80; v < kCamera.height; ++v) {
    ASSERT_NEAR(exact.depth(30, v), kCamera.fy / (v - kCamera.cy), 1e-5);
  }
  EXPECT_EQ(exact.depth(30, 40), 0);
}

TEST(Cast, AnyNumberOfThreadsGivesTheSameBits) {
  const Scene scene = make_demo_scene(3);
  const Pose T_camera_world = look_at({0.4, -1.1, 0.6}, {0, 0, 0}, Eigen::Vector3d::UnitZ()).inverse();
  EXPECT_EQ(cast_color(scene, kCamera, T_camera_world, 2, 1), cast_color(scene, kCamera, T_camera_world, 2, 5));
  EXPECT_EQ(cast_depth(scene, kCamera, T_camera_world, false, 1).depth,
            cast_depth(scene, kCamera, T_camera_world, false, 3).depth);
}

TEST(CastColor, BackgroundShowsWhereNoSolidIs) {
  const Scene scene = scene_of({grey_solid(Solid::Shape::box, {0.5, 0.5, 0.2}, {0, 0, 1.6})});
  const ColorImage image = cast_color(scene, kCamera, Pose::Identity(), 2);
  EXPECT_EQ(image(3, 3), (Rgb8{10, 20, 30}));
  EXPECT_NE(image(80, 60), (Rgb8{10, 20, 30}));
}

TEST(CastColor, EdgePixelsMixBothSides) {
  // Its right edge goes through the middle of column 80.
  const Solid solid = grey_solid(Solid::Shape::box, {2, 4, 1}, {-1 + 0.5 / 140 * 2, 0, 2.5});
  const ColorImage image = cast_color(scene_of({solid}), kCamera, Pose::Identity(), 4);
  const int inside = image(70, 60).r;
  const int outside = image(90, 60).r;
  EXPECT_EQ(outside, 10);
  EXPECT_GT(inside, 40);
  EXPECT_NEAR(image(80, 60).r, 0.5 * (inside + outside), 3);
}

TEST(CastColor, SolidThrowsItsShadowAwayFromTheLamp) {
  const Solid floor = grey_solid(Solid::Shape::box, {2, 2, 0.1}, {0, 0, -0.05});
  const Solid tower = grey_solid(Solid::Shape::box, {0.1, 0.1, 0.3}, {0, 0, 0.15});
  const Pose T_camera_world = look_at({0, -0.01, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY()).inverse();
  const auto brightness_at = [&](const Scene& scene, double x, double y) {
    const Eigen::Vector2d pixel = kCamera.project(T_camera_world * Eigen::Vector3d(x, y, 0));
    return cast_color(scene, kCamera, T_camera_world, 1)(static_cast<int>(std::lround(pixel.x())),
                                                         static_cast<int>(std::lround(pixel.y())))
        .r;
  };
  const Scene empty = scene_of({floor});
  const Scene with_tower = scene_of({floor, tower});
  // The lamp stands to the left and in front.
  EXPECT_LT(brightness_at(with_tower, 0.14, 0.06), 0.8 * brightness_at(empty, 0.14, 0.06));
  EXPECT_EQ(brightness_at(with_tower, -0.14, -0.06), brightness_at(empty, -0.14, -0.06));
}

}  // namespace
}  // namespace meshloop::simulation
