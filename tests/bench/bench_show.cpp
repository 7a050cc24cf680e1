// Time to draw the two views of a comparison, with legend and frames.
#include <benchmark/benchmark.h>

#include "carry_on_cpu.h"
#include "common/simulation/camera_path.h"
#include "common/simulation/demo_scene.h"
#include "common/simulation/sensor.h"
#include "server/show/carry.h"
#include "server/show/overlay.h"

namespace meshloop {
namespace {

/// The demo's scene as a Kinect sees it, of which the model knows a part.
struct View {
  Rig rig;
  DepthImage measured;
  Comparison comparison;
  RegionMap regions;
  ColorImage color;

  View(int width, int height) : color{width, height, {120, 100, 80}} {
    rig.depth = {640, 480, 585, 585, 319.5, 239.5, {}};
    const double focal = 0.82 * width;
    rig.color = {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0, {}};
    rig.T_depth_color = make_pose({0.025, 0, 0}, Eigen::Quaterniond::Identity());
    const auto scene = simulation::make_demo_scene(1);
    const Pose T_depth_world = rig.T_depth_color * simulation::StationPath{}.at(0).inverse();
    measured = simulation::measure(simulation::cast_depth(scene, rig.depth, T_depth_world, false), rig.depth,
                                   rig.sensor, {1, 7});
    comparison.expected = simulation::cast_depth(scene, rig.depth, T_depth_world, true).depth;
    label();
  }

 private:
  void label() {
    comparison.labels = Image<Label>{640, 480};
    comparison.difference_m = Image<float>{640, 480};
    regions.ids = Image<RegionId>{640, 480};
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const float z = measured.data()[i];
      const float difference = z - comparison.expected.data()[i];
      const bool changed = z > 0 && difference < -0.02f;
      comparison.labels.data()[i] = changed ? Label::closer : z > 0 ? Label::agrees : Label::unmeasured;
      comparison.difference_m.data()[i] = difference;
      regions.ids.data()[i] = changed ? 1 : 0;
    }
    Region region;
    region.id = 1;
    region.confirmed = true;
    regions.regions = {region};
  }
};

void over_depth(benchmark::State& state) {
  const View s{640, 480};
  for (auto _ : state) benchmark::DoNotOptimize(overlay_on_depth(s.comparison, s.measured, &s.regions, {}).data());
}
BENCHMARK(over_depth)->Unit(benchmark::kMillisecond);

// What the live station waits for: the whole picture.
void over_color(benchmark::State& state) {
  const View s{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  const auto gpu = GpuContext::create_headless().value();
  auto overlay = ColorOverlay::create(*gpu).value();
  state.SetLabel(gpu->description());
  for (auto _ : state) {
    benchmark::DoNotOptimize(overlay.draw(s.comparison, s.measured, s.color, s.rig, &s.regions, {}));
  }
}
BENCHMARK(over_color)
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

// Visibility alone: by the GPU, and by the reference that the tests compare it with.
template <bool kOnGpu>
void carry(benchmark::State& state) {
  const View s{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  const auto gpu = GpuContext::create_headless().value();
  const auto carrier = show::Carrier::create(*gpu).value();
  for (auto _ : state) {
    if constexpr (kOnGpu) {
      benchmark::DoNotOptimize(carrier->carry(s.comparison, s.measured, s.rig));
    } else {
      benchmark::DoNotOptimize(carry_on_cpu(s.comparison, s.measured, s.rig));
    }
  }
}
BENCHMARK(carry<true>)
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(carry<false>)
    ->Args({640, 480})
    ->Args({1280, 720})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace meshloop
