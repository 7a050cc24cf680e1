// One frame of 640x480 against models of several sizes: rendering, the whole comparison, and the same on the CPU.
// State: triangles.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <utility>

#include "common/gpu/mesh_cache.h"
#include "common/gpu/scene_renderer.h"
#include "kinect_camera.h"
#include "server/compare/comparator.h"
#include "server/compare/region_tracker.h"

namespace meshloop {
namespace {

// A wavy surface that fills the picture at 1.5 to 2.5 metres, in 25 nodes.
Model wavy_model(std::int64_t triangles) {
  constexpr int kTiles = 5;
  const int cells = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(triangles) / 2) / kTiles));
  Model model;
  for (int tile = 0; tile < kTiles * kTiles; ++tile) {
    Submesh submesh;
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        const float x =
            4 * (static_cast<float>(tile % kTiles) + static_cast<float>(j) / static_cast<float>(cells)) / kTiles - 2;
        const float y =
            4 * (static_cast<float>(tile / kTiles) + static_cast<float>(i) / static_cast<float>(cells)) / kTiles - 2;
        submesh.positions.emplace_back(x, y, 2 + 0.5F * std::sin(5 * x) * std::cos(4 * y));
        submesh.colors.push_back({200, 120, 40});
      }
    }
    const auto row = static_cast<std::uint32_t>(cells + 1);
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const std::uint32_t here = static_cast<std::uint32_t>(i) * row + static_cast<std::uint32_t>(j);
        submesh.triangles.push_back({here, here + row, here + 1});
        submesh.triangles.push_back({here + 1, here + row, here + row + 1});
      }
    }
    model.nodes.push_back(make_node(static_cast<NodeId>(tile + 1), "tile", std::move(submesh)));
  }
  return model;
}

// What the sensor sees: the model a little closer in a quarter of the picture, where a change is.
struct Frame {
  explicit Frame(std::int64_t triangles) : model{wavy_model(triangles)} {
    Image<std::uint32_t> nodes;
    render_on_cpu(model, test::kinect_camera(), Pose::Identity(), measured, nodes);
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u) measured(u, v) -= 0.2F;
    }
    input.model = &model;
    input.camera = test::kinect_camera();
    input.pose.state = TrackState::tracking;
    input.pose.covariance = 1e-6 * PoseCovariance::Identity();
    input.measured = &measured;
    input.wait_for_detail = true;
  }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;

  Model model;
  DepthImage measured;
  CompareInput input;
};

void render_on_gpu(benchmark::State& state) {
  const auto context = GpuContext::create_headless();
  const auto renderer = context ? SceneRenderer::create(**context) : fail(context.error());
  if (!renderer) return state.SkipWithError(renderer.error().message.c_str());
  const Model model = wavy_model(state.range(0));
  SceneView view;
  view.camera = test::kinect_camera();
  view.nodes = view.color = state.range(1) < 2;
  if (state.range(1) != 0) {
    const SensorModel sensor;
    view.tolerance = Tolerance{[&](double z_m) { return kDetailShare * sensor.sigma_z_m(z_m, 0); }};
    (*context)->meshes().finish(model);
  }
  for (auto _ : state) {
    (*renderer)->render(model, view);
    benchmark::DoNotOptimize((*renderer)->read_depth());
  }
  state.SetLabel((*context)->description());
}

void compare_on_gpu(benchmark::State& state) {
  const auto context = GpuContext::create_headless();
  const auto comparator = context ? Comparator::create(**context) : fail(context.error());
  if (!comparator) return state.SkipWithError(comparator.error().message.c_str());
  const Frame frame(state.range(0));
  CompareTimes sum;
  for (auto _ : state) {
    CompareTimes times;
    benchmark::DoNotOptimize((*comparator)->compare(frame.input, &times));
    sum.upload_ms += times.upload_ms;
    sum.render_ms += times.render_ms;
    sum.compare_ms += times.compare_ms;
    sum.readback_ms += times.readback_ms;
  }
  const auto mean = [](double value) { return benchmark::Counter(value, benchmark::Counter::kAvgIterations); };
  state.counters["upload_ms"] = mean(sum.upload_ms);
  state.counters["render_ms"] = mean(sum.render_ms);
  state.counters["compare_ms"] = mean(sum.compare_ms);
  state.counters["readback_ms"] = mean(sum.readback_ms);
}

void compare_all_on_cpu(benchmark::State& state) {
  const Frame frame(state.range(0));
  for (auto _ : state) {
    DepthImage depth;
    Image<std::uint32_t> nodes;
    render_on_cpu(frame.model, frame.input.camera, Pose::Identity(), depth, nodes);
    benchmark::DoNotOptimize(compare_on_cpu(frame.input, depth, nodes));
  }
}

void find_regions(benchmark::State& state) {
  const Frame frame(1280);
  DepthImage depth;
  Image<std::uint32_t> nodes;
  render_on_cpu(frame.model, frame.input.camera, Pose::Identity(), depth, nodes);
  const Comparison comparison = compare_on_cpu(frame.input, depth, nodes);
  RegionTracker tracker{RegionOptions{}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(tracker.update(comparison, frame.measured, frame.input.camera, Pose::Identity()));
  }
}

BENCHMARK(render_on_gpu)
    ->ArgsProduct({{15'000, 500'000, 2'500'000}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(compare_on_gpu)
    ->Arg(1'280)
    ->Arg(15'000)
    ->Arg(2'500'000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(compare_all_on_cpu)
    ->Arg(1'280)
    ->Arg(15'000)
    ->Arg(111'000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(find_regions)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace meshloop
