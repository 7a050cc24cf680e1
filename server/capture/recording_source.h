#pragma once
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "common/image/rectifier.h"
#include "common/recording/recording.h"
#include "server/capture/rgbd_source.h"

namespace meshloop {

/// Plays a recording back as if it were a live rig. Used from one thread.
class RecordingSource : public RgbdSource {
 public:
  struct Options {
    /// True: next() sleeps until the frame is due, counted from the first call. False: as fast as frames are read.
    bool real_time = false;
    /// Replaces the rig's sensor model, in the calibration too.
    std::optional<SensorModel> sensor = std::nullopt;
  };

  /// Refuses a recording without depth images. `rig_file` replaces the recording's own rig.yaml.
  [[nodiscard]] static Result<std::unique_ptr<RecordingSource>> open(
      const std::filesystem::path& folder, const std::optional<std::filesystem::path>& rig_file, Options options);
  [[nodiscard]] static Result<std::unique_ptr<RecordingSource>> open(
      const std::filesystem::path& folder, const std::optional<std::filesystem::path>& rig_file = std::nullopt) {
    return open(folder, rig_file, Options{});
  }

  [[nodiscard]] const Rig& rig() const override { return rig_; }
  [[nodiscard]] const Rig& calibration() const override { return calibration_; }
  Result<std::optional<RgbdFrame>> next() override;
  [[nodiscard]] std::optional<int> frame_count() const override {
    return static_cast<int>(recording_.depth_images().size());
  }

  /// What is being played, for its ground truth and its length.
  [[nodiscard]] const Recording& recording() const { return recording_; }

 private:
  RecordingSource(Recording recording, Options options);
  void wait_until_due(double timestamp_s);

  Recording recording_;
  Options options_;
  Rig calibration_;
  Rig rig_;
  Rectifier rectify_color_;
  Rectifier rectify_depth_;
  int next_index_ = 0;
  std::optional<std::chrono::steady_clock::time_point> started_;
};

}  // namespace meshloop
