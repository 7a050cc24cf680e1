// One whole frame of difference detection (upload, render or cast, compare, label, regions), for models and pictures of
// several sizes: on the GPU with levels of detail and with every triangle, by the reference on the CPU, and with
// Embree's rays and the comparison on the CPU. tests/bench/table.py makes a table with ratios of the JSON output.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>
#include <random>
#include <thread>
#include <tuple>
#include <utility>

#include "common/gpu/mesh_cache.h"
#include "common/gpu/scene_renderer.h"
#include "kinect_camera.h"
#include "scenes.h"
#include "server/compare/background_comparator.h"
#include "server/compare/region_tracker.h"
#ifdef MESHLOOP_EMBREE
#include "embree_scene.h"
#endif

namespace meshloop {
namespace {

using test::kinect_camera;

struct Scene {
  std::string name;
  std::int64_t triangles;
  friend auto operator<=>(const Scene&, const Scene&) = default;
};

/// The present scene and what is made of it: one at a time, since a large one fills memory.
struct World {
  std::unique_ptr<GpuContext> gpu;
  std::unique_ptr<SceneRenderer> renderer;
  std::unique_ptr<BackgroundComparator> comparator;
  Scene scene;
  Model model;
#ifdef MESHLOOP_EMBREE
  std::unique_ptr<bench::EmbreeScene> embree;
#endif

  void show(const Scene& wanted) {
    if (gpu == nullptr) {
      gpu = std::move(GpuContext::create_headless().value());
      renderer = std::move(SceneRenderer::create(*gpu).value());
      comparator = std::move(BackgroundComparator::create().value());
    }
    if (scene == wanted) return;
    scene = wanted;
    static const std::map<std::string, Model (*)(std::int64_t)> kScenes{
        {"relief", bench::relief}, {"room", bench::room}, {"stones", bench::stones}};
    model = kScenes.at(wanted.name)(wanted.triangles);
#ifdef MESHLOOP_EMBREE
    embree.reset();
#endif
  }
};

World& world() {
  static World the_world;
  return the_world;
}

/// What the sensor sees, with its noise: the model, and a box in front of it that the model does not have.
DepthImage measured_by(const Camera& camera) {
  SceneView view;
  view.camera = camera;
  world().renderer->render(world().model, view);
  DepthImage depth = world().renderer->read_depth();
  for (int v = camera.height / 4; v < camera.height / 2; ++v) {
    for (int u = camera.width / 4; u < camera.width / 2; ++u) depth(u, v) = std::max(0.0F, depth(u, v) - 0.2F);
  }
  std::mt19937 random{1};
  std::normal_distribution<double> normal;
  const SensorModel sensor = CompareInput{}.sensor;
  for (float& z : depth.pixels()) {
    if (z > 0) z += static_cast<float>(sensor.sigma_z_m(static_cast<double>(z), 0) * normal(random));
  }
  return depth;
}

CompareInput input_of(const DepthImage& measured, const Camera& camera) {
  CompareInput input;
  input.model = &world().model;
  input.camera = camera;
  input.pose.state = TrackState::tracking;
  input.pose.covariance = 1e-6 * PoseCovariance::Identity();
  input.wait_for_detail = true;
  input.measured = &measured;
  return input;
}

/// One frame's regions are found while the next one is compared, as in the station.
void on_gpu(benchmark::State& state, const Scene& scene, int width, int height, double detail_share) {
  world().show(scene);
  const Camera camera = kinect_camera(width, height);
  const DepthImage measured = measured_by(camera);
  CompareInput input = input_of(measured, camera);
  input.detail_share = detail_share;
  RegionTracker regions{RegionOptions{}};
  std::optional<PendingComparison> next{world().comparator->begin(input)};
  if (const auto first = next->take(); !first) return state.SkipWithError(first.error().message.c_str());
  next.emplace(world().comparator->begin(input));
  for (auto _ : state) {
    const auto compared = next->take();
    if (!compared) return state.SkipWithError(compared.error().message.c_str());
    next.emplace(world().comparator->begin(input));
    benchmark::DoNotOptimize(regions.update(compared->comparison, measured, camera, Pose::Identity()));
  }
}

/// The reference of the tests: one thread, double precision, every triangle.
void on_cpu(benchmark::State& state, const Scene& scene, int width, int height) {
  world().show(scene);
  const Camera camera = kinect_camera(width, height);
  const DepthImage measured = measured_by(camera);
  const CompareInput input = input_of(measured, camera);
  RegionTracker regions{RegionOptions{}};
  DepthImage depth;
  Image<std::uint32_t> nodes;
  for (auto _ : state) {
    render_on_cpu(world().model, camera, Pose::Identity(), depth, nodes);
    benchmark::DoNotOptimize(regions.update(compare_on_cpu(input, depth, nodes), measured, camera, Pose::Identity()));
  }
}

#ifdef MESHLOOP_EMBREE
/// A band of rows as a picture of its own.
template <class T>
Image<T> band_of(const Image<T>& image, int from, int to) {
  Image<T> band(image.width(), to - from);
  std::copy(image.data() + from * image.width(), image.data() + to * image.width(), band.data());
  return band;
}

Comparison compare_band(const DepthImage& measured, const Camera& camera, const DepthImage& depth,
                        const Image<std::uint32_t>& nodes, int from, int to) {
  Camera part = camera;
  part.height = to - from;
  part.cy -= from;
  const DepthImage band = band_of(measured, from, to);
  return compare_on_cpu(input_of(band, part), band_of(depth, from, to), band_of(nodes, from, to));
}

void with_embree(benchmark::State& state, const Scene& scene, int width, int height, bool compare) {
  world().show(scene);
  const unsigned threads = std::thread::hardware_concurrency();
  if (!world().embree) world().embree = std::make_unique<bench::EmbreeScene>(world().model, threads);
  const Camera camera = kinect_camera(width, height);
  const DepthImage measured = measured_by(camera);
  DepthImage depth(width, height);
  Image<std::uint32_t> nodes(width, height);
  RegionTracker regions{RegionOptions{}};
  for (auto _ : state) {
    world().embree->cast(camera, depth, nodes);
    benchmark::DoNotOptimize(depth);
    if (!compare) continue;
    std::vector<Comparison> parts(threads);
    {
      std::vector<std::jthread> workers;
      for (unsigned k = 0; k < threads; ++k) {
        const int from = height * static_cast<int>(k) / static_cast<int>(threads);
        const int to = height * static_cast<int>(k + 1) / static_cast<int>(threads);
        workers.emplace_back([&, k, from, to] { parts[k] = compare_band(measured, camera, depth, nodes, from, to); });
      }
    }
    Comparison whole{Image<Label>(width, height), Image<float>(width, height), depth, nodes,
                     Image<float>(width, height)};
    std::size_t at = 0;
    for (const auto& part : parts) {
      std::copy_n(part.labels.data(), part.labels.size(), whole.labels.data() + at);
      std::copy_n(part.difference_m.data(), part.labels.size(), whole.difference_m.data() + at);
      std::copy_n(part.threshold_m.data(), part.labels.size(), whole.threshold_m.data() + at);
      at += part.labels.size();
    }
    benchmark::DoNotOptimize(regions.update(whole, measured, camera, Pose::Identity()));
  }
}
#endif

void add(const std::string& name, const std::function<void(benchmark::State&)>& run) {
  benchmark::RegisterBenchmark(name.c_str(), run)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MeasureProcessCPUTime()
      ->MinTime(0.4);
}

void add_all() {
  constexpr std::array<std::pair<int, int>, 3> kPictures{{{176, 144}, {320, 240}, {640, 480}}};
  for (const char* surface : {"relief", "room", "stones"}) {
    for (const std::int64_t triangles : {1'280, 15'000, 111'000, 500'000, 1'000'000, 2'500'000}) {
      for (const auto& [width, height] : kPictures) {
        const Scene scene{surface, triangles};
        const std::string name = fmt::format("{}/{}/{}x{}", surface, triangles, width, height);
        const int w = width;
        const int h = height;
        add(name + "/detail", [=](benchmark::State& state) { on_gpu(state, scene, w, h, kDetailShare); });
        add(name + "/exact", [=](benchmark::State& state) { on_gpu(state, scene, w, h, 0); });
        add(name + "/cpu", [=](benchmark::State& state) { on_cpu(state, scene, w, h); });
#ifdef MESHLOOP_EMBREE
        add(name + "/embree", [=](benchmark::State& state) { with_embree(state, scene, w, h, true); });
        add(name + "/embree_rays_alone", [=](benchmark::State& state) { with_embree(state, scene, w, h, false); });
#endif
      }
    }
  }
}

[[maybe_unused]] const bool kAdded = (add_all(), true);

}  // namespace
}  // namespace meshloop
