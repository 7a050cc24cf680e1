// How true new surface is: two boxes on a floor, a Kinect with all its faults,
// eight frames of a held camera.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "boxes.h"
#include "server/adjust/depth_buffer.h"
#include "server/adjust/depth_fusion.h"
#include "server/adjust/proposal.h"

namespace meshloop {
namespace {

using boxes::Box;

const Box kFloor{{-2, 0.3, -1}, {2, 0.4, 3}, 1, true, 100};
const Box kWall{{-2, -2, 2.2}, {2, 2, 2.3}, 2, true, 100};
const std::vector<Box> kNew{{{-0.2, 0.0, 0.9}, {0.15, 0.3, 1.2}}, {{-0.5, 0.1, 1.2}, {-0.28, 0.3, 1.35}}};
const Camera kCamera{640, 480, 580, 580, 319.5, 239.5, {}};
const SensorModel kKinect{SensorModel::Kind::kinect1};

std::vector<Box> all_boxes() {
  std::vector<Box> all{kFloor, kWall};
  all.insert(all.end(), kNew.begin(), kNew.end());
  return all;
}

Pose view_from(double x, double y, double z) {
  return look_at({x, y, z}, {-0.1, 0.2, 1.1}, {0, -1, 0});
}
Pose held(int i) {
  return view_from(0.35 + 0.003 * std::sin(2.1 * i), -0.4 + 0.003 * std::cos(1.7 * i), 0.15 + 0.002 * std::sin(i));
}

struct Captured {
  std::unique_ptr<boxes::World> world;
  std::vector<DepthImage> depths;
  FusedDepth fused;

  explicit Captured(unsigned seed) {
    boxes::WorldOptions options;
    options.depth = options.color = kCamera;
    options.sensor = kKinect;
    options.with_all_faults = true;
    options.seed = seed;
    options.threshold_sigmas = 5;
    world = make_world(all_boxes(), held(0), options);
    depths.reserve(8);
    std::vector<DepthView> views{{&world->frame.depth, held(0).inverse()}};
    for (int i = 1; i < 8; ++i) {
      depths.push_back(
          boxes::measure(all_boxes(), kCamera, held(i).inverse(), kKinect, 1000 * seed + static_cast<unsigned>(i)));
      views.push_back({&depths.back(), held(i).inverse()});
    }
    fused = fuse_depth(views, kCamera, kKinect, fused_pixels(world->regions));
  }
  [[nodiscard]] Snapshot snapshot() const {
    Snapshot snapshot = world->snapshot();
    snapshot.fused = &fused;
    return snapshot;
  }
  /// All that is new, as one surface.
  [[nodiscard]] Model adjusted(const AdjustOptions& options) const {
    const auto merged = merge_edits(world->model, propose(snapshot(), 100, options));
    return *apply(world->model, merged->edits, 2);
  }
};

double distance_to(const Box& box, const Eigen::Vector3d& p) {
  const Eigen::Vector3d inside = (p - box.low).cwiseMin(box.high - p);
  const Eigen::Vector3d outside = (-inside).cwiseMax(0);
  return inside.minCoeff() >= 0 ? inside.minCoeff() : outside.norm();
}

std::size_t new_triangles(const Model& model) {
  std::size_t count = 0;
  for (const auto& node : model.nodes) count += node.id >= 100 ? node.submesh->triangles.size() : 0;
  return count;
}

/// What a camera would see of a model.
DepthImage drawn(const Model& model, const Pose& T_camera_world) {
  adjust::DepthBuffer buffer{adjust::Window{0, 0, kCamera.width, kCamera.height}};
  for (const auto& node : model.nodes) {
    const std::vector<std::uint32_t> what(node.submesh->triangles.size(), 0);
    draw(*node.submesh, what, T_camera_world * node.T_world_node, kCamera, buffer);
  }
  DepthImage depth{kCamera.width, kCamera.height};
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) depth(x, y) = buffer.depth(x, y);
  }
  return depth;
}

AdjustOptions decimated() {
  AdjustOptions options;
  options.decimate_sigmas = 0.3;
  return options;
}

// Points of the new surface, spread evenly, against the nearest true one.
TEST(SurfaceFigures, LieWithinHalfASigmaOnAverage) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Captured captured{seed};
    const Model model = captured.adjusted(decimated());
    // From where it was captured: every pixel of new surface is one point.
    Model only_new;
    for (const auto& node : model.nodes) {
      if (node.id >= 100) only_new.nodes.push_back(node);
    }
    const DepthImage seen = drawn(only_new, held(0).inverse());
    double sum_sigmas = 0;
    int count = 0;
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        const auto z = static_cast<double>(seen(x, y));
        if (!(z > 0)) continue;
        const Eigen::Vector3d p = held(0) * kCamera.back_project(x, y, z);
        double nearest = distance_to(kFloor, p);
        for (const auto& box : kNew) nearest = std::min(nearest, distance_to(box, p));
        sum_sigmas += nearest / kKinect.sigma_z_m(z, 0);
        ++count;
      }
    }
    std::printf("mean distance %.3f sigma over %d pixels\n", sum_sigmas / count, count);
    EXPECT_GT(count, 40'000);
    EXPECT_LT(sum_sigmas / count, 0.5);
  }
}

TEST(SurfaceFigures, DecimationLeavesATenthOfTheTriangles) {
  const Captured captured{1};
  AdjustOptions raw;
  raw.flatten = false;
  const std::size_t before = new_triangles(captured.adjusted(raw));
  const std::size_t after = new_triangles(captured.adjusted(decimated()));
  std::printf("%zu of %zu triangles\n", after, before);
  EXPECT_LT(10 * after, before);
}

// Pixels that show new surface which the captured view saw too, from places up
// to 20 degrees beside it.
TEST(SurfaceFigures, UnseenViewsAgree) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Captured captured{seed};
    const Model model = captured.adjusted(decimated());
    const auto captured_truth = boxes::cast(all_boxes(), kCamera, held(0).inverse());
    int agreeing = 0;
    int all = 0;
    for (const Pose& T_world_view :
         {view_from(0.1, -0.4, 0.1), view_from(0.6, -0.35, 0.3), view_from(0.3, -0.7, 0.3)}) {
      const Pose T_view_world = T_world_view.inverse();
      const auto truth = boxes::cast(all_boxes(), kCamera, T_view_world);
      const DepthImage expected = drawn(model, T_view_world);
      for (int y = 0; y < kCamera.height; ++y) {
        for (int x = 0; x < kCamera.width; ++x) {
          if (truth.box(x, y) < 3) continue;
          const auto z = static_cast<double>(truth.depth(x, y));
          const Eigen::Vector3d p = held(0).inverse() * (T_world_view * kCamera.back_project(x, y, z));
          const Eigen::Vector2d pixel = kCamera.project(p);
          if (!kCamera.contains(pixel, 2)) continue;
          const auto u = static_cast<int>(std::lround(pixel.x()));
          const auto v = static_cast<int>(std::lround(pixel.y()));
          const float there = captured_truth.depth(u, v);
          if (std::abs(static_cast<double>(there) - p.z()) > 0.01) continue;  // hidden from the captured view
          if (!(captured.fused.depth(u, v) > 0)) continue;                    // the sensor's blind spots
          ++all;
          if (std::abs(static_cast<double>(expected(x, y)) - z) <= 3 * kKinect.sigma_z_m(z, 0)) ++agreeing;
        }
      }
    }
    std::printf("%.2f %% of %d pixels agree\n", 100.0 * agreeing / all, all);
    EXPECT_GT(all, 100'000);
    EXPECT_GT(agreeing, 0.97 * all);
  }
}

}  // namespace
}  // namespace meshloop
