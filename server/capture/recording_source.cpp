#include "server/capture/recording_source.h"

#include <fmt/format.h>

#include <thread>
#include <utility>

namespace meshloop {
namespace {

Rig calibrated(Rig rig, const std::optional<SensorModel>& sensor) {
  if (sensor) rig.sensor = *sensor;
  return rig;
}

}  // namespace

Result<std::unique_ptr<RecordingSource>> RecordingSource::open(const std::filesystem::path& folder,
                                                               const std::optional<std::filesystem::path>& rig_file,
                                                               Options options) {
  auto recording = rig_file ? Recording::open(folder, *rig_file) : Recording::open(folder);
  if (!recording) return fail(recording.error());
  if (recording->depth_images().empty()) {
    return fail(fmt::format("the recording '{}' has no depth.txt; the station needs depth images", folder.string()));
  }
  return std::unique_ptr<RecordingSource>{new RecordingSource{std::move(*recording), std::move(options)}};
}

RecordingSource::RecordingSource(Recording recording, Options options)
    : recording_{std::move(recording)},
      options_{std::move(options)},
      calibration_{calibrated(recording_.rig(), options_.sensor)},
      rig_{calibration_},
      rectify_color_{rig_.color},
      rectify_depth_{rig_.depth} {
  rig_.color = rig_.color.without_distortion();
  rig_.depth = rig_.depth.without_distortion();
}

Result<std::optional<RgbdFrame>> RecordingSource::next() {
  const auto& images = recording_.depth_images();
  if (static_cast<std::size_t>(next_index_) >= images.size()) return std::nullopt;
  const int index =
      next_index_++;  // counted first, so that a frame that cannot be read is passed over by the next call
  if (options_.real_time) wait_until_due(images[static_cast<std::size_t>(index)].timestamp_s);
  auto frame = recording_.read_frame(index);
  if (!frame) return fail(frame.error());
  frame->color = rectify_color_.rectify(frame->color);
  frame->depth = rectify_depth_.rectify(frame->depth);
  return std::optional{std::move(*frame)};
}

void RecordingSource::wait_until_due(double timestamp_s) {
  const auto now = std::chrono::steady_clock::now();
  if (!started_) started_ = now;
  const std::chrono::duration<double> since_first{timestamp_s - recording_.depth_images().front().timestamp_s};
  std::this_thread::sleep_until(*started_ +
                                std::chrono::duration_cast<std::chrono::steady_clock::duration>(since_first));
}

}  // namespace meshloop
