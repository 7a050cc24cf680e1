#pragma once
// The recordings of the demo, frame by frame. Frames are made on any threads, begun in their order, each made or
// skipped exactly once; they are written in their order.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/recording/recording.h"
#include "common/simulation/camera_path.h"
#include "common/simulation/demo_data.h"
#include "common/simulation/parallel.h"
#include "common/simulation/scene.h"

namespace meshloop::simulation {

/// The demo's rig: a Kinect's two cameras, 25 mm apart and turned by half a degree, or one pair of eyes when it is
/// registered. Without noise the depth unit is 0.25 mm, so that rounding moves a depth by 0.125 mm at most; float depth
/// is in metres.
[[nodiscard]] Rig demo_rig(const DemoOptions& options);

/// Colour and depth of the station, and the true depth images. The scenes must outlive it.
class StationRecording {
 public:
  [[nodiscard]] static Result<std::unique_ptr<StationRecording>> create(const std::filesystem::path& folder,
                                                                        const Scene& before, const Scene& after,
                                                                        const DemoOptions& options);

  [[nodiscard]] int frames() const { return options_.station_frames; }
  [[nodiscard]] Status make_frame(int index);
  void skip_frame(int index) { const Turns::Turn turn(turns_, index); }
  /// After the last frame: station_truth/frames.txt.
  [[nodiscard]] Status finish() const;

 private:
  StationRecording(RecordingWriter writer, std::filesystem::path truth, const Scene& before, const Scene& after,
                   const DemoOptions& options);
  [[nodiscard]] Status write_truth(int index, const Pose& T_depth_world, const DepthImage& measured) const;

  DemoOptions options_;
  Rig rig_;
  const Scene& before_;
  const Scene& after_;
  RecordingWriter writer_;
  std::filesystem::path truth_;
  std::vector<std::string> lines_;
  Turns turns_;
};

/// Colour of the handheld. The scene must outlive it.
class DeviceRecording {
 public:
  [[nodiscard]] static Result<std::unique_ptr<DeviceRecording>> create(const std::filesystem::path& folder,
                                                                       const Scene& scene, const DemoOptions& options,
                                                                       const DevicePath& path,
                                                                       std::uint64_t noise_seed);

  [[nodiscard]] Status make_frame(int index);
  void skip_frame(int index) { const Turns::Turn turn(turns_, index); }

 private:
  DeviceRecording(RecordingWriter writer, const Scene& scene, const DemoOptions& options, const DevicePath& path,
                  std::uint64_t noise_seed);

  DemoOptions options_;
  Rig rig_;
  const Scene& scene_;
  DevicePath path_;
  std::uint64_t noise_seed_;
  RecordingWriter writer_;
  Turns turns_;
};

}  // namespace meshloop::simulation
