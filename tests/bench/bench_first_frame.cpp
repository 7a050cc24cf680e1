// From a model file to the first frames: reading it, the first frame (every triangle), until the levels of detail are
// there, and the memory that this takes; for Embree, building its hierarchy.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/base/clock.h"
#include "common/gpu/mesh_cache.h"
#include "common/interchange/model_file.h"
#include "kinect_camera.h"
#include "scenes.h"
#include "server/compare/comparator.h"
#ifdef MESHLOOP_EMBREE
#include "embree_scene.h"
#endif

namespace meshloop {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;

/// The model as a binary PLY file, gone with this object.
class ModelFile {
 public:
  explicit ModelFile(std::int64_t triangles)
      : path_{std::filesystem::temp_directory_path() / fmt::format("meshloop-bench-{}.ply", ::getpid())} {
    const Status written = export_model(bench::room(triangles), path_);
    if (!written) throw std::runtime_error(written.error().message);
  }
  ~ModelFile() { std::filesystem::remove(path_); }
  ModelFile(const ModelFile&) = delete;
  ModelFile& operator=(const ModelFile&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Peak of the process's resident memory since the last `forget_peak`, in MB.
double peak_mb() {
  std::ifstream status{"/proc/self/status"};
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

void forget_peak() {
  malloc_trim(0);
  std::ofstream{"/proc/self/clear_refs"} << "5";
}

void first_frame(benchmark::State& state) {
  const ModelFile file{state.range(0)};
  const Camera camera = test::kinect_camera(kWidth, kHeight);
  const DepthImage measured(kWidth, kHeight, 1.0F);
  for (auto _ : state) {
    forget_peak();
    Stopwatch watch;
    const auto lap = [&](const char* name) {
      state.counters[name] = watch.milliseconds();
      watch.restart();
    };
    const Model model = import_as_model(file.path()).value().model;
    lap("load_ms");
    const auto gpu = std::move(GpuContext::create_headless().value());
    const auto comparator = std::move(Comparator::create(*gpu).value());
    lap("context_ms");
    CompareInput input;
    input.model = &model;
    input.camera = camera;
    input.pose.state = TrackState::tracking;
    input.measured = &measured;
    benchmark::DoNotOptimize(comparator->compare(input, nullptr).value());
    lap("first_frame_ms");
    gpu->meshes().finish(model);
    lap("until_detail_ms");
    benchmark::DoNotOptimize(comparator->compare(input, nullptr).value());
    state.counters["peak_MB"] = peak_mb();
  }
}

void once_a_size(benchmark::internal::Benchmark* bench) {
  for (const std::int64_t triangles : {15'000, 500'000, 2'500'000}) bench->Arg(triangles);
  bench->Iterations(1)->UseRealTime()->Unit(benchmark::kMillisecond);
}

#ifdef MESHLOOP_EMBREE
void embree_build(benchmark::State& state) {
  const Model model = bench::room(state.range(0));
  for (auto _ : state) bench::EmbreeScene scene{model, 2};
}
BENCHMARK(embree_build)->Apply(once_a_size);
#endif

BENCHMARK(first_frame)->Apply(once_a_size);

}  // namespace
}  // namespace meshloop
