// Time to draw the two views of a comparison, with legend and frames.
#include <benchmark/benchmark.h>

#include "server/show/overlay.h"

namespace meshloop {
namespace {

/// A surface of which the middle has changed.
struct ChangedSurface {
  Rig rig;
  DepthImage measured{640, 480, 1.5f};
  Comparison comparison;
  RegionMap regions;
  ColorImage color;

  ChangedSurface(int width, int height) : color{width, height, {120, 100, 80}} {
    rig.depth = {640, 480, 585, 585, 319.5, 239.5, {}};
    const double focal = 0.82 * width;
    rig.color = {width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0, {}};
    rig.T_depth_color = make_pose({0.025, 0, 0}, Eigen::Quaterniond::Identity());
    comparison.labels = Image<Label>{640, 480, Label::agrees};
    comparison.difference_m = Image<float>{640, 480};
    comparison.expected = measured;
    regions.ids = Image<RegionId>{640, 480};
    for (int y = 100; y < 300; ++y) {
      for (int x = 100; x < 400; ++x) {
        comparison.labels(x, y) = Label::closer;
        comparison.difference_m(x, y) = -0.03f;
        regions.ids(x, y) = 1;
      }
    }
    Region region;
    region.id = 1;
    region.confirmed = true;
    regions.regions = {region};
  }
};

void over_depth(benchmark::State& state) {
  const ChangedSurface s{640, 480};
  for (auto _ : state) benchmark::DoNotOptimize(overlay_on_depth(s.comparison, s.measured, {}).data());
}
BENCHMARK(over_depth)->Unit(benchmark::kMillisecond);

void over_color(benchmark::State& state) {
  const ChangedSurface s{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  for (auto _ : state) {
    benchmark::DoNotOptimize(overlay_on_color(s.comparison, s.measured, s.color, s.rig, &s.regions, {}).data());
  }
}
BENCHMARK(over_color)->Args({640, 480})->Args({1280, 720})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace meshloop
