#include "server/adjust/flat_parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "boxes.h"

namespace meshloop::adjust {
namespace {

using boxes::Box;
using boxes::make_world;
using boxes::WorldOptions;

const Camera kCamera{640, 480, 580, 580, 319.5, 239.5, {}};

/// The largest distance of a pixel on a plane from the nearest face of the boxes, in metres.
struct Measured {
  double largest_m = 0;
  double rms_m = 0;
  int on_planes = 0;
  int members = 0;
};

double distance_to_face(const Box& box, const Eigen::Vector3d& p) {
  double nearest = 1;
  for (int k = 0; k < 3; ++k) {
    nearest = std::min({nearest, std::abs(p[k] - box.low[k]), std::abs(p[k] - box.high[k])});
  }
  return nearest;
}

Measured measure_planes(const boxes::World& world, const Box& box, const DepthGrid& grid, const FlatParts& parts) {
  Measured m;
  const Pose T_world_depth = world.T_depth_world.inverse();
  for (std::size_t i = 0; i < grid.z.size(); ++i) {
    m.members += grid.role[i] == Role::member ? 1 : 0;
    if (parts.plane_of_pixel[i] == 0) continue;
    const int x = static_cast<int>(i) % grid.window.width() + grid.window.x0;
    const int y = static_cast<int>(i) / grid.window.width() + grid.window.y0;
    const Eigen::Vector3d p = T_world_depth * kCamera.back_project(x, y, static_cast<double>(grid.z[i]));
    const double d = distance_to_face(box, p);
    m.largest_m = std::max(m.largest_m, d);
    m.rms_m += d * d;
    ++m.on_planes;
  }
  m.rms_m = std::sqrt(m.rms_m / std::max(m.on_planes, 1));
  return m;
}

const Box kWall{{-2, -2, 2}, {2, 2, 2.1}, 1, true, 100};
const Box kBox{{-0.2, -0.15, 0.9}, {0.2, 0.15, 1.2}};

std::unique_ptr<boxes::World> box_at_a_metre(unsigned seed) {
  WorldOptions options;
  options.depth = kCamera;
  options.color = kCamera;
  options.sensor = SensorModel{SensorModel::Kind::kinect1};
  options.with_all_faults = true;
  options.seed = seed;
  options.threshold_m = 0.02;
  return make_world({kWall, kBox}, look_at({0.5, -0.45, 0.2}, {0, 0, 1.05}, {0, -1, 0}), options);
}

DepthGrid grid_of(const boxes::World& world) {
  return select_patch(world.comparison, world.frame.depth, {}, world.regions.ids,
                      world.region(ChangeKind::insertion).id, world.rig.sensor);
}

TEST(FlatParts, FindsTheFacesOfABoxToAFifthOfAMillimetre) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto world = box_at_a_metre(seed);
    DepthGrid grid = grid_of(*world);
    const FlatParts parts = find_flat_parts(grid);
    snap_to_planes(grid, parts);
    const Measured m = measure_planes(*world, kBox, grid, parts);
    std::printf("%zu planes; %d of %d pixels; largest %.2f mm, rms %.2f mm\n", parts.planes.size(), m.on_planes,
                m.members, 1000 * m.largest_m, 1000 * m.rms_m);
    EXPECT_EQ(parts.planes.size(), 3u);
    EXPECT_GT(m.on_planes, 0.995 * m.members);
    EXPECT_LT(m.largest_m, 0.0002);
  }
}

TEST(FlatParts, NoTriangleOfAPatchTurnsAwayFromTheCamera) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto world = box_at_a_metre(seed);
    const auto patch = insertion_patch(world->snapshot(), world->region(ChangeKind::insertion).id, {});
    const Eigen::Vector3f eye = world->T_depth_world.inverse().translation().cast<float>();
    double turned_m2 = 0;
    double all_m2 = 0;
    for (const auto& [a, b, c] : patch.triangles) {
      const Eigen::Vector3f& p = patch.positions[a];
      const Eigen::Vector3f normal = (patch.positions[b] - p).cross(patch.positions[c] - p);
      const double area_m2 = 0.5 * static_cast<double>(normal.norm());
      all_m2 += area_m2;
      if (normal.dot(eye - p) < 0) turned_m2 += area_m2;
    }
    std::printf("%.2f cm2 of %.0f face away\n", 1e4 * turned_m2, 1e4 * all_m2);
    EXPECT_LT(turned_m2, 0.00001);
  }
}

// Single pixels without a measurement within a face are closed, larger holes are not.
TEST(FlatParts, GapsOfAPixelAreFilledOnThePlane) {
  const auto world = box_at_a_metre(1);
  DepthGrid grid = grid_of(*world);
  DepthImage measured = world->frame.depth;
  FlatParts parts = find_flat_parts(grid);
  const int w = grid.window.width();
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y * w + x); };
  const int x = w / 2;
  const int y = grid.window.height() / 2;
  const auto plane = parts.plane_of_pixel[at(x, y)];
  ASSERT_NE(plane, 0);
  const auto forget = [&](int u, int v) {
    measured(u + grid.window.x0, v + grid.window.y0) = 0;
    grid.role[at(u, v)] = Role::outside;
    parts.plane_of_pixel[at(u, v)] = 0;
  };
  forget(x, y);
  for (int k = 0; k < 16; ++k) forget(x + 10 + k % 4, y + k / 4);
  fill_gaps(grid, parts, measured);
  EXPECT_EQ(grid.role[at(x, y)], Role::gap);
  EXPECT_EQ(parts.plane_of_pixel[at(x, y)], plane);
  EXPECT_EQ(grid.role[at(x + 11, y + 1)], Role::outside);
}

}  // namespace
}  // namespace meshloop::adjust
