#include "server/adjust/registration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "boxes.h"

namespace meshloop {
namespace {

using boxes::Box;
using boxes::make_world;
using boxes::World;
using boxes::WorldOptions;

const SensorModel kKinect{SensorModel::Kind::kinect1};

/// A corner of a room with things in it, and a fifth of the picture changed.
std::vector<Box> furnished(bool with_changes) {
  std::vector<Box> boxes{{{-2, 0.6, -1}, {2, 0.7, 3}, 1},
                         {{-2, -2, 2.2}, {2, 2, 2.3}, 2},
                         {{-1.3, -2, -1}, {-1.2, 2, 3}, 3},
                         {{0.2, 0.2, 1.2}, {0.6, 0.6, 1.5}, 4},
                         {{-0.7, 0.3, 1.5}, {-0.3, 0.6, 1.8}, 5}};
  if (!with_changes) return boxes;
  boxes.push_back({{-0.3, -0.4, 1.0}, {0.25, 0.2, 1.1}, 0});        // came
  boxes.push_back({{0.4, -0.6, 1.6}, {0.9, -0.1, 1.9}, 6, false});  // went
  return boxes;
}

/// The model as expected from a wrong pose; measured from the right one.
std::unique_ptr<World> misplaced(std::vector<Box> boxes, const Pose& T_world_true, const Twist& error, unsigned seed) {
  for (auto& box : boxes) box.edge_m = 100;
  WorldOptions options;
  options.sensor = kKinect;
  const Pose T_world_wrong = T_world_true * exp(error);
  auto world = make_world(boxes, T_world_wrong, options);
  std::vector<Box> real;
  for (const auto& box : boxes) {
    if (box.real) real.push_back(box);
  }
  world->frame.depth = boxes::cast(real, options.depth, T_world_true.inverse()).depth;
  std::mt19937 random{seed};
  std::normal_distribution<float> noise;
  for (auto& z : world->frame.depth.pixels()) {
    if (z > 0) z += noise(random) * static_cast<float>(kKinect.sigma_z_m(static_cast<double>(z), 0));
  }
  return world;
}

/// The snapshot says that it may be as wrong as that.
Snapshot uncertain(const World& world, double sigma_m, double sigma_rad) {
  Snapshot snapshot = world.snapshot();
  snapshot.depth_pose.covariance.diagonal() << Eigen::Vector3d::Constant(sigma_m * sigma_m),
      Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return snapshot;
}

double distance_m(const Pose& T_camera_world, const Pose& T_world_true) {
  return (T_camera_world.inverse().translation() - T_world_true.translation()).norm();
}
double angle_degrees(const Pose& T_camera_world, const Pose& T_world_true) {
  return log(T_camera_world * T_world_true).tail<3>().norm() * 180 / std::numbers::pi;
}

Twist off_by(std::mt19937& random, double metres, double degrees) {
  std::normal_distribution<double> any;
  Eigen::Vector3d shift{any(random), any(random), any(random)};
  Eigen::Vector3d turn{any(random), any(random), any(random)};
  Twist twist;
  twist << metres * shift.normalized(), degrees * std::numbers::pi / 180 * turn.normalized();
  return twist;
}

/// The pixels of the box that came, as a region of their own.
RegionId region_of_the_box(World& world) {
  Region region;
  region.id = 1;
  region.kind = ChangeKind::insertion;
  region.confirmed = true;
  world.regions.ids = Image<RegionId>{world.rig.depth.width, world.rig.depth.height};
  for (int y = 0; y < world.rig.depth.height; ++y) {
    for (int x = 0; x < world.rig.depth.width; ++x) {
      const float nearer = world.comparison.expected(x, y) - world.frame.depth(x, y);
      world.comparison.labels(x, y) = nearer > 0.2F ? Label::closer : Label::agrees;
      world.regions.ids(x, y) = nearer > 0.2F ? region.id : 0;
    }
  }
  world.regions.regions = {region};
  return region.id;
}

TEST(Registration, FindsItsPlaceWithAFifthOfTheSceneChanged) {
  std::mt19937 random{1};
  const Pose T_world_true = look_at({0.3, -0.5, -0.2}, {-0.2, 0.3, 1.6}, {0, -1, 0});
  double worst_mm = 0;
  double worst_degrees = 0;
  for (unsigned i = 0; i < 20; ++i) {
    const auto world = misplaced(furnished(true), T_world_true, off_by(random, 0.02, 2), i);
    const auto found = refine_pose(uncertain(*world, 0.02, 0.03));
    EXPECT_FALSE(found.refused) << *found.refused;
    EXPECT_EQ(found.held_directions, 6);
    EXPECT_LT(found.after_m, found.before_m);
    worst_mm = std::max(worst_mm, 1000 * distance_m(found.T_camera_world, T_world_true));
    worst_degrees = std::max(worst_degrees, angle_degrees(found.T_camera_world, T_world_true));
  }
  std::printf("at worst %.2f mm and %.3f degrees\n", worst_mm, worst_degrees);
  EXPECT_LT(worst_mm, 3);
  EXPECT_LT(worst_degrees, 0.2);
}

TEST(Registration, DoesNotSlideAlongABareCorridor) {
  const std::vector<Box> corridor{{{-1, 1, -5}, {1, 1.1, 50}, 1},
                                  {{-1, -1.1, -5}, {1, -1, 50}, 2},
                                  {{-1.1, -1, -5}, {-1, 1, 50}, 3},
                                  {{1, -1, -5}, {1.1, 1, 50}, 4}};
  std::mt19937 random{2};
  for (unsigned i = 0; i < 10; ++i) {
    const Twist error = off_by(random, 0.02, 1);
    const auto world = misplaced(corridor, Pose::Identity(), error, i);
    const auto found = refine_pose(uncertain(*world, 0.02, 0.03));
    ASSERT_FALSE(found.refused) << *found.refused;
    EXPECT_EQ(found.held_directions, 5);
    const Eigen::Vector3d left = found.T_camera_world.inverse().translation();
    EXPECT_LT(left.head<2>().norm(), 0.003);
    EXPECT_LT(angle_degrees(found.T_camera_world, Pose::Identity()), 0.2);
    EXPECT_NEAR(left.z(), error[2], 0.004) << "nothing tells where along the corridor it is";
  }
}

TEST(Registration, KeepsAPoseThatIsRight) {
  const Pose T_world_true = look_at({0.3, -0.5, -0.2}, {-0.2, 0.3, 1.6}, {0, -1, 0});
  const auto world = misplaced(furnished(true), T_world_true, Twist::Zero(), 3);
  const auto found = refine_pose(uncertain(*world, 0.002, 0.003));
  EXPECT_LT(distance_m(found.T_camera_world, T_world_true), 0.001);
}

TEST(Registration, RefusesMoreThanThePosesOwnUncertainty) {
  const Pose T_world_true = look_at({0.3, -0.5, -0.2}, {-0.2, 0.3, 1.6}, {0, -1, 0});
  std::mt19937 random{4};
  const auto world = misplaced(furnished(false), T_world_true, off_by(random, 0.02, 1), 4);
  const auto found = refine_pose(uncertain(*world, 0.0005, 0.0005));
  ASSERT_TRUE(found.refused);
  EXPECT_NE(found.refused->find("sigma"), std::string::npos) << *found.refused;
  EXPECT_TRUE(found.T_camera_world.isApprox(world->snapshot().depth_pose.T_camera_world));
}

TEST(Registration, LeavesAnExactPoseAlone) {
  const auto world = misplaced(furnished(false), Pose::Identity(), Twist::Zero(), 6);
  ASSERT_TRUE(world->snapshot().depth_pose.covariance.isZero());
  EXPECT_TRUE(refine_pose(world->snapshot()).refused);
}

TEST(Registration, PlacesAPatchWhereItBelongs) {
  // What came, on a plane at z = 1, seen by a camera that is 1 cm and a third of a degree off.
  const Pose T_world_true = look_at({0.3, -0.5, -0.2}, {-0.2, 0.3, 1.6}, {0, -1, 0});
  Twist error;
  error << 0, 0, 0.01, 0, 0.006, 0;
  const auto world = misplaced(furnished(true), T_world_true, error, 7);
  Snapshot snapshot = uncertain(*world, 0.01, 0.01);
  const auto mean_error_m = [&] {
    double sum = 0;
    std::size_t count = 0;
    for (const auto& p : insertion_patch(snapshot, region_of_the_box(*world), {}).positions) {
      if (std::abs(p.z() - 1) > 0.05F) continue;
      sum += std::abs(static_cast<double>(p.z()) - 1);
      ++count;
    }
    return count > 0 ? sum / static_cast<double>(count) : 1.0;
  };
  const double before_m = mean_error_m();
  snapshot.refined_T_camera_world = refine_pose(snapshot).T_camera_world;
  EXPECT_GT(before_m, 0.003);
  EXPECT_LT(mean_error_m(), 0.0015);
}

TEST(Registration, RefusesAnotherScene) {
  // The model's room is not the one that is measured.
  const std::vector<Box> elsewhere{{{-3, -3, 0.7}, {3, 3, 0.8}, 0}};
  auto world = misplaced(furnished(false), Pose::Identity(), Twist::Zero(), 5);
  world->frame.depth = boxes::cast(elsewhere, world->rig.depth, Pose::Identity()).depth;
  EXPECT_TRUE(refine_pose(uncertain(*world, 0.02, 0.03)).refused);
  for (auto& z : world->frame.depth.pixels()) z = 0;
  EXPECT_TRUE(refine_pose(uncertain(*world, 0.02, 0.03)).refused);
}

}  // namespace
}  // namespace meshloop
