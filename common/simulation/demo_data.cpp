#include "common/simulation/demo_data.h"

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "common/interchange/model_file.h"
#include "common/recording/marker_file.h"
#include "common/simulation/demo_recordings.h"
#include "common/simulation/demo_scene.h"
#include "common/simulation/random.h"

namespace meshloop::simulation {
namespace {

namespace fs = std::filesystem;

// Gives about 100,000 triangles in the model.
constexpr double kEdge_m = 0.02;
// So near on one side that the box fills the picture, and a model that is wrong there is of no use.
constexpr double kFarthest_m = 0.57;
constexpr double kNearest_m = 0.45;

Status check(const DemoOptions& options) {
  if (!(options.noise >= 0 && options.noise <= 10)) return fail("noise must be from 0 to 10", ErrorKind::usage);
  const auto usable = [](int frames) { return frames >= 2 && frames <= 100'000; };
  if (!usable(options.station_frames) || !usable(options.device_frames)) {
    return fail("a recording of the demo needs 2 to 100000 frames", ErrorKind::usage);
  }
  if (auto ok = validate(demo_rig(options)); !ok) return fail(ok.error().message, ErrorKind::usage);
  return {};
}

Status write_model(const Scene& scene, bool modelled_only, const fs::path& file) {
  Model model;
  model.revision = 1;
  for (auto& [name, submesh] : tessellate(scene, modelled_only, kEdge_m)) {
    model.nodes.push_back(make_node(model.nodes.size() + 1, name, std::move(submesh)));
  }
  return export_model(model, file);
}

/// Counts frames for the caller and keeps the first error, from any thread.
class Progress {
 public:
  Progress(int all, const std::function<void(int, int)>& report) : all_{all}, report_{report} {}

  [[nodiscard]] bool failed() const { return failed_; }
  void frame_done(const Status& status) {
    const std::lock_guard lock(mutex_);
    if (!status && !error_) error_ = status.error();
    failed_ = error_.has_value();
    if (report_) report_(++done_, all_);
  }
  [[nodiscard]] Status status() const {
    if (error_) return fail(*error_);
    return {};
  }

 private:
  std::mutex mutex_;
  int all_;
  const std::function<void(int, int)>& report_;
  int done_ = 0;
  std::optional<Error> error_;
  std::atomic<bool> failed_ = false;
};

using DeviceRecordings = std::vector<std::unique_ptr<DeviceRecording>>;

Result<DeviceRecordings> device_recordings(const fs::path& folder, const Scene& before, const Scene& after,
                                           const DemoOptions& options) {
  struct Walk {
    const char* name;
    const Scene& scene;
    double farthest_m;
    double nearest_m;
  };
  const std::array<Walk, 3> walks{{{"device", after, 1.15, 1.15},
                                   {"device_before_move", before, kFarthest_m, kNearest_m},
                                   {"device_after_move", after, kFarthest_m, kNearest_m}}};
  DeviceRecordings recordings;
  std::uint64_t seed = mix(options.seed);
  for (const Walk& walk : walks) {
    auto recording = DeviceRecording::create(folder / walk.name, walk.scene, options,
                                             {.farthest_m = walk.farthest_m, .nearest_m = walk.nearest_m}, mix(++seed));
    if (!recording) return fail(recording.error());
    recordings.push_back(std::move(*recording));
  }
  return recordings;
}

Status write_recordings(const fs::path& folder, const Scene& before, const Scene& after, const DemoOptions& options,
                        const std::function<void(int, int)>& report) {
  auto station = StationRecording::create(folder, before, after, options);
  if (!station) return fail(station.error());
  auto devices = device_recordings(folder, before, after, options);
  if (!devices) return fail(devices.error());

  const int of_station = (*station)->frames();
  const int all = of_station + static_cast<int>(devices->size()) * options.device_frames;
  Progress progress(all, report);
  const auto make = [&](auto& recording, int index) {
    // After a failure the others that wait for their turn must still get it.
    if (progress.failed()) return recording.skip_frame(index);
    progress.frame_done(recording.make_frame(index));
  };
  for_each_parallel(all, processor_count(), [&](int i) {
    if (i < of_station) return make(**station, i);
    const int of_devices = i - of_station;
    make(*(*devices)[static_cast<std::size_t>(of_devices / options.device_frames)], of_devices % options.device_frames);
  });
  if (auto ok = progress.status(); !ok) return ok;
  return (*station)->finish();
}

}  // namespace

Status write_demo_data(const fs::path& folder, const DemoOptions& options,
                       const std::function<void(int, int)>& progress) {
  if (auto ok = check(options); !ok) return ok;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("cannot make the folder '" + folder.string() + "': " + error.message());
  const Scene before = make_demo_scene(options.seed);
  const Scene after = with_moved_object(before, "box", kBoxMove_m);
  if (auto ok = write_markers(folder / "markers.yaml", demo_markers()); !ok) return ok;
  if (auto ok = write_model(before, true, folder / "model.ply"); !ok) return ok;
  if (auto ok = write_model(before, false, folder / "model_before_move.ply"); !ok) return ok;
  return write_recordings(folder, before, after, options, progress);
}

}  // namespace meshloop::simulation
