#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "boxes.h"
#include "common/mesh/lattice.h"
#include "server/adjust/proposal.h"

namespace meshloop {
namespace {

using boxes::Box;
using boxes::make_world;
using boxes::World;
using boxes::WorldOptions;

const Box kWall{{-2, -2, 2}, {2, 2, 2.1}, 1};
const Box kObject{{-0.15, -0.1, 1.5}, {0.15, 0.12, 1.7}};

double distance_to_surface(const Box& box, const Eigen::Vector3d& p) {
  const Eigen::Vector3d inside = (p - box.low).cwiseMin(box.high - p);
  const Eigen::Vector3d outside = (-inside).cwiseMax(0);
  return inside.minCoeff() >= 0 ? inside.minCoeff() : outside.norm();
}

/// Pixels as they were measured.
AdjustOptions not_flattened() {
  AdjustOptions options;
  options.flatten = false;
  return options;
}

// A camera beside the world's origin and turned, so that poses matter.
Pose turned_pose() {
  return look_at({0.2, -0.1, 0.1}, {0, 0, 1.6}, {0, -1, 0});
}

TEST(Insertion, PatchLiesOnTheMeasuredSurface) {
  const auto world = make_world({kWall, kObject}, turned_pose());
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, not_flattened());
  ASSERT_TRUE(validate(patch).has_value());
  for (const auto& p : patch.positions) {
    EXPECT_LT(distance_to_surface(kObject, p.cast<double>()), 2.5e-4) << p.transpose();
  }
  EXPECT_TRUE(is_on_lattice(patch));
}

TEST(Insertion, HasTwoTrianglesForEachBlockOfAFrontalFace) {
  const auto world = make_world({kWall, kObject}, Pose::Identity());
  const Region region = world->region(ChangeKind::insertion);
  const auto patch = insertion_patch(world->snapshot(), region.id, {});
  const auto blocks = region.pixel_box.sizes();
  EXPECT_EQ(patch.triangles.size(), 2u * static_cast<std::size_t>(blocks.x()) * static_cast<std::size_t>(blocks.y()));
  EXPECT_EQ(patch.positions.size(), static_cast<std::size_t>(region.pixels));
}

TEST(Insertion, FacesTheCamera) {
  const auto world = make_world({kWall, kObject}, turned_pose());
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
  const Eigen::Vector3f eye = world->T_depth_world.inverse().translation().cast<float>();
  for (const auto& [a, b, c] : patch.triangles) {
    const Eigen::Vector3f& p = patch.positions[a];
    EXPECT_GT((patch.positions[b] - p).cross(patch.positions[c] - p).dot(eye - p), 0);
  }
}

TEST(Insertion, DoesNotSpanADiscontinuity) {
  // Two objects 15 cm apart in depth, side by side in the picture: one region.
  const Box behind{{0.15, -0.1, 1.65}, {0.4, 0.12, 1.8}};
  const auto world = make_world({kWall, kObject, behind}, Pose::Identity());
  ASSERT_EQ(world->regions.regions.size(), 1u);
  const auto patch = insertion_patch(world->snapshot(), 1, {});
  for (const auto& [a, b, c] : patch.triangles) {
    const float za = patch.positions[a].z();
    EXPECT_LT(std::abs(za - patch.positions[b].z()), 0.05f);
    EXPECT_LT(std::abs(za - patch.positions[c].z()), 0.05f);
  }
  const auto bounds = patch.bounds();
  EXPECT_NEAR(bounds.min().z(), 1.5f, 1e-3f);
  EXPECT_NEAR(bounds.max().z(), 1.65f, 1e-3f);
}

TEST(Insertion, SpansASteepFaceBelowEightyDegrees) {
  // The box's top face is seen at about 70 degrees.
  const Pose camera = look_at({0, -0.55, 0.2}, {0, 0, 1.6}, {0, -1, 0});
  const Box long_box{{-0.2, -0.05, 1.2}, {0.2, 0.3, 1.7}};
  const auto world = make_world({kWall, long_box}, camera);
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
  // Area of top and front faces, less at most a rim of two pixels.
  double area = 0;
  for (const auto& [a, b, c] : patch.triangles) {
    const Eigen::Vector3f& p = patch.positions[a];
    area += 0.5 * static_cast<double>((patch.positions[b] - p).cross(patch.positions[c] - p).norm());
  }
  EXPECT_NEAR(area, 0.4 * 0.5 + 0.4 * 0.35, 0.015);
}

TEST(Insertion, MeetsTheModelWhereItStandsOnIt) {
  // y points down: a floor at y = 0.3, a box on it, seen from above.
  const Box floor{{-1, 0.3, 0.3}, {1, 0.4, 3}, 1};
  const Box box{{-0.1, 0.1, 1.4}, {0.1, 0.3, 1.6}};
  const auto world = make_world({floor, box}, look_at({0, -0.4, 0.6}, {0, 0.2, 1.5}, {0, -1, 0}));
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
  // The lowest vertices of the front face lie on the floor, though pixels within the threshold of it are not changed.
  std::size_t on_floor = 0;
  for (const auto& p : patch.positions) {
    if (std::abs(p.y() - 0.3f) < 3e-4f) ++on_floor;
    EXPECT_LT(p.y(), 0.3f + 3e-4f);
  }
  EXPECT_GT(on_floor, 30u);
}

TEST(Insertion, DropsSmallPieces) {
  const Box speck{{0, 0, 1.5}, {0.012, 0.012, 1.6}};  // about 2 x 2 pixels
  const auto world = make_world({kWall, speck}, Pose::Identity());
  const auto id = world->region(ChangeKind::insertion).id;
  ASSERT_NE(id, 0u);
  EXPECT_TRUE(insertion_patch(world->snapshot(), id, {}).triangles.empty());
  AdjustOptions all;
  all.min_patch_triangles = 1;
  EXPECT_FALSE(insertion_patch(world->snapshot(), id, all).triangles.empty());
}

TEST(Insertion, OfASpeckNothingIsDecimated) {
  const Box speck{{0, 0, 1.5}, {0.012, 0.012, 1.6}};
  const auto world = make_world({kWall, speck}, Pose::Identity());
  AdjustOptions options;
  options.decimate_sigmas = 0.3;
  EXPECT_TRUE(insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, options).triangles.empty());
}

TEST(Insertion, WhatIsSmallFollowsTheSizeOfTheImage) {
  const Box speck{{0, 0, 1.5}, {0.012, 0.012, 1.6}};
  auto world = make_world({kWall, speck}, Pose::Identity());
  const auto id = world->region(ChangeKind::insertion).id;
  const auto size = [&] {
    AdjustOptions all;
    all.min_patch_triangles = 1;
    return insertion_patch(world->snapshot(), id, all).triangles.size();
  }();
  const auto pixels = static_cast<double>(world->frame.depth.size());
  AdjustOptions options;
  // As many at 640x480 as this patch would have there.
  options.min_patch_triangles = static_cast<std::size_t>(static_cast<double>(size) * 640 * 480 / pixels);
  EXPECT_FALSE(insertion_patch(world->snapshot(), id, options).triangles.empty());
  options.min_patch_triangles = static_cast<std::size_t>(static_cast<double>(size + 1) * 640 * 480 / pixels);
  EXPECT_TRUE(insertion_patch(world->snapshot(), id, options).triangles.empty());
}

TEST(Insertion, TakesUnmodelledPixels) {
  Box unknown_wall = kWall;
  unknown_wall.node = 0;
  const auto world = make_world({unknown_wall}, turned_pose());
  ASSERT_EQ(world->comparison.labels(10, 10), Label::unmodelled);
  const auto patch = insertion_patch(world->snapshot(), 1, {});
  EXPECT_EQ(patch.positions.size(), 320u * 240u);
  EXPECT_EQ(patch.triangles.size(), 2u * 319u * 239u);
}

TEST(Insertion, SmoothingLeavesLessThanHalfTheNoiseOfAPlane) {
  Box unknown_wall = kWall;
  unknown_wall.node = 0;
  WorldOptions options;
  options.sensor = SensorModel{SensorModel::Kind::kinect1};
  options.noise = 1;
  const auto world = make_world({unknown_wall}, Pose::Identity(), options);
  const auto rms = [&](bool smooth) {
    AdjustOptions adjust = not_flattened();
    adjust.smooth = smooth;
    const auto patch = insertion_patch(world->snapshot(), 1, adjust);
    double sum = 0;
    for (const auto& p : patch.positions) sum += std::pow(static_cast<double>(p.z()) - 2.0, 2);
    return std::sqrt(sum / static_cast<double>(patch.positions.size()));
  };
  EXPECT_NEAR(rms(false), 0.006, 0.0005);
  EXPECT_LT(rms(true), 0.003);
}

TEST(Insertion, IsRoundedToAFifthOfTheNoiseAtMost) {
  Box unknown_wall = kWall;
  unknown_wall.node = 0;
  const auto coarsening_with = [&](double sigma_m) {
    WorldOptions options;
    options.sensor = SensorModel{SensorModel::Kind::constant, sigma_m};
    options.noise = 1;
    const auto world = make_world({unknown_wall}, turned_pose(), options);
    const auto patch = insertion_patch(world->snapshot(), 1, not_flattened());
    return patch.triangles.empty() ? 0 : coarsening_of(patch);
  };
  // Sigmas of which the rounding of one, two and four steps is just below a fifth.
  EXPECT_EQ(coarsening_with(0.0003), 1);
  EXPECT_EQ(coarsening_with(0.00072), 2);
  EXPECT_EQ(coarsening_with(0.0015), 4);
  EXPECT_EQ(coarsening_with(0.01), 4);
}

TEST(Insertion, IsNotRoundedToTheWidthOfItsPixels) {
  Box unknown_wall = kWall;
  unknown_wall.node = 0;
  WorldOptions options;  // two metres away: 0.7 mm a pixel
  options.depth = Camera{320, 240, 2900, 2900, 159.5, 119.5, {}};
  options.sensor = SensorModel{SensorModel::Kind::constant, 0.005};
  const auto world = make_world({unknown_wall}, Pose::Identity(), options);
  const auto patch = insertion_patch(world->snapshot(), 1, not_flattened());
  EXPECT_EQ(coarsening_of(patch), 2);
  EXPECT_EQ(patch.triangles.size(), 2U * 319U * 239U);
}

TEST(Insertion, KeepsToTheStepsOfColorsOnWhite) {
  WorldOptions options;
  options.paint = [](const Eigen::Vector3d&) { return Rgb8{255, 254, 3}; };
  const auto world = make_world({kWall, kObject}, turned_pose(), options);
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
  ASSERT_FALSE(patch.colors.empty());
  for (const auto& color : patch.colors) {
    EXPECT_EQ((color.r | color.g | color.b) % kCoarseColorStep, 0);
    EXPECT_EQ(color.r, 248);
  }
}

TEST(Insertion, SmoothingKeepsCorners) {
  // A vertical edge towards the camera: two faces at 45 degrees, in a frame turned by 45 degrees.
  const Pose camera = look_at({-0.8, 0, -0.8}, {0, 0, 0}, {0, -1, 0});
  const Box corner{{0, -0.3, 0}, {0.4, 0.3, 0.4}};
  WorldOptions options;
  options.sensor = SensorModel{SensorModel::Kind::kinect1};
  const auto world = make_world({corner}, camera, options);
  const auto patch = insertion_patch(world->snapshot(), 1, {});
  double largest = 0;
  for (const auto& p : patch.positions) {
    largest = std::max(largest, distance_to_surface(corner, p.cast<double>()));
  }
  EXPECT_LT(largest, 0.002);
}

TEST(Insertion, ColorsComeFromTheColorCamera) {
  WorldOptions options;
  options.T_depth_color = make_pose({0.025, 0, 0}, Eigen::Quaterniond::Identity());
  options.paint = [](const Eigen::Vector3d& p) {
    const auto shade = [](double at_m) { return static_cast<std::uint8_t>(std::clamp(128 + 400 * at_m, 0.0, 255.0)); };
    return Rgb8{shade(p.x()), shade(p.y()), 77};
  };
  const auto world = make_world({kWall, kObject}, Pose::Identity(), options);
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
  ASSERT_EQ(patch.colors.size(), patch.positions.size());
  std::size_t right = 0;
  for (std::size_t i = 0; i < patch.colors.size(); ++i) {
    const Rgb8 true_color = options.paint(patch.positions[i].cast<double>());
    // 3 for the position of the vertex in the pixel, 2 for the rounding of colours to 4 levels.
    right += std::abs(patch.colors[i].r - true_color.r) <= 5 && std::abs(patch.colors[i].g - true_color.g) <= 5;
  }
  // A pixel at the silhouette may mix object and wall.
  EXPECT_GT(static_cast<double>(right), 0.97 * static_cast<double>(patch.colors.size()));
}

TEST(Insertion, TakesNoColorFromASurfaceInFront) {
  // The colour camera 20 cm to the right sees the red post where the depth camera sees the wall beside it.
  WorldOptions options;
  options.T_depth_color = make_pose({0.2, 0, 0}, Eigen::Quaterniond::Identity());
  options.paint = [](const Eigen::Vector3d& p) { return p.z() < 1.9 ? Rgb8{255, 0, 0} : Rgb8{0, 200, 0}; };
  Box unknown_wall = kWall;
  unknown_wall.node = 0;
  const Box post{{0.1, -1, 1.0}, {0.2, 1, 1.1}, 2};
  const auto world = make_world({unknown_wall, post}, Pose::Identity(), options);
  const auto id = world->regions.ids(10, 120);
  ASSERT_NE(id, 0u);
  const auto patch = insertion_patch(world->snapshot(), id, {});
  std::size_t red = 0;
  for (std::size_t i = 0; i < patch.colors.size(); ++i) red += patch.colors[i].r > 40;
  EXPECT_LT(static_cast<double>(red), 0.002 * static_cast<double>(patch.colors.size()));
}

TEST(Insertion, LeavesOutImpossibleDepthsAndOnlyThose) {
  auto world = make_world({kWall, kObject}, Pose::Identity());
  world->rig.sensor = SensorModel{SensorModel::Kind::kinect1};
  const auto id = world->region(ChangeKind::insertion).id;
  const auto before = insertion_patch(world->snapshot(), id, not_flattened()).positions.size();
  world->frame.depth(160, 120) = std::numeric_limits<float>::infinity();
  world->frame.depth(150, 120) = std::numeric_limits<float>::quiet_NaN();
  world->frame.depth(170, 120) = -1;
  const auto patch = insertion_patch(world->snapshot(), id, not_flattened());
  EXPECT_TRUE(validate(patch).has_value());
  EXPECT_EQ(patch.positions.size(), before - 3);
}

TEST(Insertion, IsGreyWithoutAColorImage) {
  auto world = make_world({kWall, kObject}, Pose::Identity());
  world->frame.color = {};
  const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
  EXPECT_THAT(patch.colors, testing::Each(Rgb8{128, 128, 128}));
}

TEST(Insertion, SplitsLargePatchesWithoutACrack) {
  Box unknown_wall = kWall;
  unknown_wall.node = 0;
  const auto world = make_world({unknown_wall}, turned_pose());
  const auto proposals = propose(world->snapshot(), 7, {});
  ASSERT_EQ(proposals.size(), 1u);
  ASSERT_GT(proposals[0].edits.size(), 1u);
  std::size_t triangles = 0;
  std::set<std::array<float, 3>> places;
  NodeId next = 7;
  for (const auto& edit : proposals[0].edits) {
    const auto& node = std::get<AddNode>(edit).node;
    EXPECT_EQ(node.id, next++);
    EXPECT_LE(node.submesh->triangles.size(), 60'000u);
    triangles += node.submesh->triangles.size();
    for (const auto& p : node.submesh->positions) places.insert({p.x(), p.y(), p.z()});
  }
  EXPECT_EQ(triangles, 2u * 319u * 239u);
  EXPECT_EQ(triangles, proposals[0].triangles_added);
  EXPECT_EQ(places.size(), 320u * 240u);
}

}  // namespace
}  // namespace meshloop
