#pragma once
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/image/rectifier.h"
#include "common/recording/recording.h"
#include "device/capture/color_source.h"

namespace meshloop {

/// Plays the colour images of a recording back as if they came from a camera. Used from one thread.
class ColorRecordingSource : public ColorSource {
 public:
  struct Options {
    /// True: next() sleeps until the frame is due, counted from the first call. False: as fast as frames are read.
    bool real_time = false;
    /// True: after the last frame comes the first again; timestamps go on growing, and the index goes on counting.
    bool loop = false;
  };

  /// `rig_file` replaces the recording's own rig.yaml.
  [[nodiscard]] static Result<std::unique_ptr<ColorRecordingSource>> open(
      const std::filesystem::path& folder, const std::optional<std::filesystem::path>& rig_file, Options options);
  [[nodiscard]] static Result<std::unique_ptr<ColorRecordingSource>> open(
      const std::filesystem::path& folder, const std::optional<std::filesystem::path>& rig_file = std::nullopt) {
    return open(folder, rig_file, Options{});
  }

  [[nodiscard]] const Camera& camera() const override { return camera_; }
  Result<std::optional<ColorFrame>> next() override;

  /// What is being played, for its ground truth and its length.
  [[nodiscard]] const Recording& recording() const { return recording_; }

 private:
  ColorRecordingSource(Recording recording, Options options);
  void wait_until_due(double timestamp_s);

  Recording recording_;
  Options options_;
  Camera camera_;
  Rectifier rectify_;
  /// From one round's first image to the next round's, in seconds.
  double round_s_;
  int next_index_ = 0;
  std::optional<std::chrono::steady_clock::time_point> started_;
};

}  // namespace meshloop
