#include "device/capture/recording_source.h"

#include <thread>
#include <utility>

namespace meshloop {
namespace {

// The recording's length and one mean interval more, so that two rounds do not share a moment.
double length_of_round(const std::vector<RecordedImage>& images) {
  constexpr double kOneImage_s = 1.0 / 30;
  if (images.size() < 2) return kOneImage_s;
  const double length_s = images.back().timestamp_s - images.front().timestamp_s;
  return length_s + length_s / static_cast<double>(images.size() - 1);
}

}  // namespace

Result<std::unique_ptr<ColorRecordingSource>> ColorRecordingSource::open(
    const std::filesystem::path& folder, const std::optional<std::filesystem::path>& rig_file, Options options) {
  auto recording = rig_file ? Recording::open(folder, *rig_file) : Recording::open(folder);
  if (!recording) return fail(recording.error());
  return std::unique_ptr<ColorRecordingSource>{new ColorRecordingSource{std::move(*recording), options}};
}

ColorRecordingSource::ColorRecordingSource(Recording recording, Options options)
    : recording_{std::move(recording)},
      options_{options},
      camera_{recording_.rig().color.without_distortion()},
      rectify_{recording_.rig().color},
      round_s_{length_of_round(recording_.color_images())} {}

Result<std::optional<ColorFrame>> ColorRecordingSource::next() {
  const auto& images = recording_.color_images();
  const int count = static_cast<int>(images.size());
  if (next_index_ >= count && !options_.loop) return std::nullopt;
  const int index =
      next_index_++;  // counted first, so that a frame that cannot be read is passed over by the next call
  const int recorded = index % count;
  const double timestamp_s = images[static_cast<std::size_t>(recorded)].timestamp_s + (index / count) * round_s_;
  if (options_.real_time) wait_until_due(timestamp_s);
  auto frame = recording_.read_color(recorded);
  if (!frame) return fail(frame.error());
  frame->index = index;
  frame->timestamp_s = timestamp_s;
  frame->color = rectify_.rectify(frame->color);
  return std::optional{std::move(*frame)};
}

void ColorRecordingSource::wait_until_due(double timestamp_s) {
  const auto now = std::chrono::steady_clock::now();
  if (!started_) started_ = now;
  const std::chrono::duration<double> since_first{timestamp_s - recording_.color_images().front().timestamp_s};
  std::this_thread::sleep_until(*started_ +
                                std::chrono::duration_cast<std::chrono::steady_clock::duration>(since_first));
}

}  // namespace meshloop
