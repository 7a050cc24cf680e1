#pragma once
// A simulated Kinect that looks at a scene, compared with the scene's model on the GPU.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <utility>

#include "common/simulation/scene.h"
#include "common/simulation/sensor.h"
#include "server/compare/comparator.h"
#include "server/compare/region_tracker.h"

namespace meshloop::compare_test {

inline constexpr double kBoxSide_m = 0.1;

/// A box (solid 2) half a metre before a wall (1); z is depth. `distance_m` is that of the box's front.
inline simulation::Scene box_before_wall(double distance_m, double x_m, double y_m) {
  simulation::Scene scene;
  simulation::Solid wall;
  wall.name = wall.object = "wall";
  wall.size = {6, 6, 0.1};
  wall.T_world_solid.translation() = Eigen::Vector3d{0, 0, distance_m + 0.5 + 0.05};
  simulation::Solid box;
  box.name = box.object = "box";
  box.size = {kBoxSide_m, kBoxSide_m, kBoxSide_m};
  box.T_world_solid.translation() = Eigen::Vector3d{x_m, y_m, distance_m + kBoxSide_m / 2};
  for (simulation::Solid* solid : {&wall, &box}) {
    solid->texture = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Rgb8{128, 128, 128}; };
    solid->modelled = true;
    scene.solids.push_back(*solid);
  }
  scene.background = [](const Eigen::Vector3d&) { return Rgb8{0, 0, 0}; };
  return scene;
}

/// edge_m: of the triangles; those of the demo's model are 12 mm long.
inline Model model_of(const simulation::Scene& scene, double edge_m) {
  Model model;
  for (auto& [name, submesh] : simulation::tessellate(scene, true, edge_m)) {
    model.nodes.push_back(make_node(model.nodes.size() + 1, name, std::move(submesh)));
  }
  return model;
}

/// The Kinect's depth camera with `width` columns.
inline Camera kinect_camera(int width) {
  const double scale = width / 640.0;
  return {width, width * 3 / 4, 585 * scale, 585 * scale, (width - 1) / 2.0, (width * 3 / 4 - 1) / 2.0, {}};
}

/// One frame, from measurement to regions.
struct SimulatedFrame {
  DepthImage measured;
  Comparison comparison;
  RegionMap regions;
};

class SimulatedViewTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto comparator = Comparator::create(*context_);
    ASSERT_TRUE(comparator) << comparator.error().message;
    comparator_ = std::move(*comparator);
  }

  /// `real` is what stands there; of it only what is modelled when `modelled_only`.
  DepthImage sense(const simulation::Scene& real, bool modelled_only, const Pose& T_camera_world, std::uint64_t seed) {
    const auto exact = simulation::cast_depth(real, camera_, T_camera_world, modelled_only);
    return simulation::measure(exact, camera_, sensor_, {1, seed});
  }

  Comparison compare(const Model& model, const DepthImage& measured, const Pose& T_camera_world,
                     const Image<std::uint8_t>* frames_averaged = nullptr) {
    CompareInput input;
    input.model = &model;
    input.camera = camera_;
    input.sensor = sensor_;
    input.pose.state = TrackState::tracking;
    input.pose.T_camera_world = T_camera_world;
    input.measured = &measured;
    input.frames_averaged = frames_averaged;
    input.wait_for_detail = true;
    auto result = comparator_->compare(input, nullptr);
    EXPECT_TRUE(result) << (result ? "" : result.error().message);
    return result ? std::move(*result) : Comparison{};
  }

  SimulatedFrame look(const Model& model, const simulation::Scene& real, bool modelled_only, const Pose& T_camera_world,
                      std::uint64_t seed, RegionTracker& tracker) {
    SimulatedFrame frame{sense(real, modelled_only, T_camera_world, seed), {}, {}};
    frame.comparison = compare(model, frame.measured, T_camera_world);
    frame.regions = tracker.update(frame.comparison, frame.measured, camera_, T_camera_world);
    return frame;
  }

  Camera camera_ = kinect_camera(320);
  SensorModel sensor_{SensorModel::Kind::kinect1};
  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<Comparator> comparator_;
};

inline std::size_t changed_pixels(const Comparison& comparison) {
  const auto counts = comparison.counts();
  std::size_t changed = 0;
  for (const auto& label : kLabels) {
    if (is_change(label.label)) changed += counts[static_cast<std::size_t>(label.label)];
  }
  return changed;
}

inline std::size_t confirmed_pixels(const RegionMap& regions) {
  std::size_t pixels = 0;
  for (const auto& region : regions.regions) pixels += region.confirmed ? static_cast<std::size_t>(region.pixels) : 0;
  return pixels;
}

}  // namespace meshloop::compare_test
