// What a simulated Kinect's noise makes of a scene that has not changed.
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "common/simulation/camera_path.h"
#include "common/simulation/demo_scene.h"
#include "sanitized.h"
#include "server/compare/components.h"
#include "simulated_view.h"

namespace meshloop {
namespace {

using namespace compare_test;

// 30 frames a second, once around the scene in 33 s.
Pose around_the_scene(int frame) {
  const simulation::StationPath path{.round_s = 1000.0 / 30, .half = 0};
  return path.at(frame / 30.0).inverse();
}

// Of the model's triangles, as in the demo.
constexpr double kEdge_m = 0.02;

struct NoiseFigures {
  /// Measured and modelled.
  std::size_t pixels = 0;
  std::size_t changed = 0;
  std::size_t confirmed = 0;
  int regions = 0;
  int largest_component = 0;
};

std::size_t comparable_pixels(const Comparison& comparison) {
  const auto& differences = comparison.difference_m.pixels();
  return static_cast<std::size_t>(
      std::count_if(differences.begin(), differences.end(), [](float d) { return !std::isnan(d); }));
}

int largest_component(const Image<Label>& labels) {
  const auto components = connect_changes(labels);
  std::vector<int> sizes(components.count + 1, 0);
  for (const auto number : components.numbers.pixels()) sizes[number] += number != 0 ? 1 : 0;
  return *std::max_element(sizes.begin(), sizes.end());
}

class SimulatedNoise : public SimulatedViewTest {
 protected:
  NoiseFigures watch(const simulation::Scene& scene, double edge_m, const std::function<Pose(int)>& pose, int frames) {
    const Model model = model_of(scene, edge_m);
    RegionTracker tracker{RegionOptions{}};
    NoiseFigures figures;
    for (int i = 0; i < frames; ++i) {
      const auto frame = look(model, scene, true, pose(i), static_cast<std::uint64_t>(i) + 1, tracker);
      figures.pixels += comparable_pixels(frame.comparison);
      figures.changed += changed_pixels(frame.comparison);
      figures.confirmed += confirmed_pixels(frame.regions);
      figures.regions += static_cast<int>(frame.regions.regions.size());
      figures.largest_component = std::max(figures.largest_component, largest_component(frame.comparison.labels));
    }
    std::printf(
        "%dx%d, %d frames: %.4f %% of what is measured and modelled changed, %.4f %% confirmed, %d regions, largest "
        "component %d\n",
        camera_.width, camera_.height, frames, share(figures.changed, figures), share(figures.confirmed, figures),
        figures.regions, figures.largest_component);
    return figures;
  }
  static double share(std::size_t part, const NoiseFigures& figures) {
    return 100 * static_cast<double>(part) / static_cast<double>(figures.pixels);
  }
};

TEST_F(SimulatedNoise, ChangesAtMostThreeOfAThousandPixels) {
  camera_ = kinect_camera(640);
  const auto figures = watch(simulation::make_demo_scene(1), kEdge_m, around_the_scene, test::kSanitized ? 2 : 12);
  EXPECT_LT(share(figures.changed, figures), 0.3);
  EXPECT_LT(share(figures.confirmed, figures), 0.02);
}

// 3 sigma of a normal distribution leave 0.27 %; the steps of a Kinect take some of its tails away. On walls that face
// the camera nothing widens the threshold, and it must not be wider than the noise either.
TEST_F(SimulatedNoise, ChangesWhatTheTheorySaysOnAWall) {
  // Always 12 distances: at a single one it depends on where it lies between two steps of the sensor.
  camera_ = kinect_camera(test::kSanitized ? 160 : 640);
  const auto before_the_wall = [](int frame) {
    return look_at(Eigen::Vector3d{0.02 * frame, 0, 0.1 * frame}, {0, 0, 2.5}, {0, -1, 0}).inverse();
  };
  const auto figures = watch(box_before_wall(1.5, 0, 0), 0.5, before_the_wall, 12);
  EXPECT_LT(share(figures.changed, figures), 0.3);
  EXPECT_GT(share(figures.changed, figures), 0.1);
  EXPECT_LT(share(figures.confirmed, figures), 0.02);
}

TEST_F(SimulatedNoise, MakesNoRegionInAThousandFramesAlongAPath) {
  if (std::getenv("MESHLOOP_FULL_SIZE") != nullptr) camera_ = kinect_camera(640);
  const auto figures = watch(simulation::make_demo_scene(1), kEdge_m, around_the_scene, test::kSanitized ? 20 : 1000);
  EXPECT_EQ(figures.regions, 0);
  EXPECT_EQ(figures.confirmed, 0U);
}

}  // namespace
}  // namespace meshloop
