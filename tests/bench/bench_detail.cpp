// What levels of detail do to the picture: triangles drawn, deviations in sigma, and labels against those of every
// triangle, for the scenes of bench_detection.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "common/detail/cluster_cut.h"
#include "common/gpu/mesh_cache.h"
#include "common/gpu/projection.h"
#include "common/gpu/scene_renderer.h"
#include "kinect_camera.h"
#include "scenes.h"
#include "server/compare/comparator.h"

namespace meshloop {
namespace {

std::size_t triangles_drawn(const Model& model, const SceneView& view) {
  ClusterCut cut;
  std::size_t triangles = 0;
  for (const auto& node : model.nodes) {
    const ClusterHierarchy hierarchy = build_hierarchy(*node.submesh);
    const Eigen::Matrix4d clip = clip_from_camera(view.camera, view.near_m, view.far_m) * node.T_world_node.matrix();
    for (const auto& range : cut.choose(hierarchy, {clip.cast<float>(), &view.tolerance})) triangles += range.count;
  }
  return triangles;
}

DepthImage depth(GpuContext& gpu, SceneRenderer& renderer, const Model& model, const SceneView& view) {
  gpu.meshes().finish(model);
  renderer.render(model, view);
  return renderer.read_depth();
}

/// A pixel beside it is farther off than a slope explains: which of the two a pixel shows is a matter of its fractions.
bool is_at_outline(const DepthImage& depth, int u, int v) {
  constexpr float kStep_m = 0.1F;
  for (const auto& [du, dv] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
    const int x = std::clamp(u + du, 0, depth.width() - 1);
    const int y = std::clamp(v + dv, 0, depth.height() - 1);
    if (std::abs(depth(x, y) - depth(u, v)) > kStep_m) return true;
  }
  return false;
}

/// |detail - exact| in sigma, ascending; outlines left out.
std::vector<double> deviations(const DepthImage& exact, const DepthImage& detail, const SensorModel& sensor) {
  std::vector<double> in_sigma;
  for (int v = 0; v < exact.height(); ++v) {
    for (int u = 0; u < exact.width(); ++u) {
      const auto z_m = static_cast<double>(exact(u, v));
      if (!(z_m > 0) || is_at_outline(exact, u, v)) continue;
      in_sigma.push_back(std::abs(static_cast<double>(detail(u, v)) - z_m) / sensor.sigma_z_m(z_m, 0));
    }
  }
  std::sort(in_sigma.begin(), in_sigma.end());
  return in_sigma;
}

/// Share of the labels that stay, at 3 sigma and with the sensor's noise, where nothing has changed.
double equal_labels(Comparator& comparator, const Model& model, const Camera& camera, DepthImage measured) {
  CompareInput input;
  std::mt19937 random{7};
  std::normal_distribution<double> noise;
  for (float& z : measured.pixels()) {
    if (z > 0) z += static_cast<float>(input.sensor.sigma_z_m(static_cast<double>(z), 0) * noise(random));
  }
  input.model = &model;
  input.camera = camera;
  input.pose.state = TrackState::tracking;
  input.pose.covariance = 1e-8 * PoseCovariance::Identity();
  input.wait_for_detail = true;
  input.measured = &measured;
  const auto detail = comparator.compare(input, nullptr).value().labels;
  input.detail_share = 0;
  const auto exact = comparator.compare(input, nullptr).value().labels;
  std::size_t equal = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) equal += exact.data()[i] == detail.data()[i] ? 1 : 0;
  return static_cast<double>(equal) / static_cast<double>(exact.size());
}

void quality(benchmark::State& state, Model (*scene)(std::int64_t)) {
  const Model model = scene(state.range(0));
  const auto gpu = std::move(GpuContext::create_headless().value());
  const auto renderer = std::move(SceneRenderer::create(*gpu).value());
  const auto comparator = std::move(Comparator::create(*gpu).value());
  const SensorModel sensor;
  SceneView view;
  view.camera = test::kinect_camera(640, 480);
  const DepthImage exact = depth(*gpu, *renderer, model, view);
  view.tolerance = Tolerance{[&](double z_m) { return kDetailShare * sensor.sigma_z_m(z_m, 0); }};
  for (auto _ : state) {
    const auto off = deviations(exact, depth(*gpu, *renderer, model, view), sensor);
    double squares = 0;
    for (const double each : off) squares += each * each;
    state.counters["triangles"] = static_cast<double>(triangles_drawn(model, view));
    state.counters["rms_sigma"] = std::sqrt(squares / static_cast<double>(off.size()));
    state.counters["of_1000_999_within_sigma"] = off[off.size() * 999 / 1000];
    state.counters["largest_sigma"] = off.back();
    state.counters["equal_labels"] = equal_labels(*comparator, model, view.camera, exact);
  }
}

BENCHMARK_CAPTURE(quality, relief, bench::relief)->Arg(2'500'000)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(quality, room, bench::room)->Arg(2'500'000)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(quality, stones, bench::stones)->Arg(2'500'000)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace meshloop
