#pragma once
// Recordings: folders in the TUM RGB-D layout with a rig.yaml (see the folder's README).
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/rig.h"
#include "common/image/frames.h"
#include "common/recording/trajectory.h"

namespace meshloop {

struct RecordedImage {
  double timestamp_s = 0;
  std::filesystem::path file;
};

/// Reads a recording. Opening reads the lists and the rig; images are read when asked for. Depth images are the frames'
/// order: frame i is line i of depth.txt, with the colour image nearest in time.
class Recording {
 public:
  /// Refuses a folder without rig.yaml or rgb.txt, and lists that do not parse. depth.txt may be missing (colour only).
  static Result<Recording> open(const std::filesystem::path& folder);
  /// The same with another rig file.
  static Result<Recording> open(const std::filesystem::path& folder, const std::filesystem::path& rig_file);

  /// The rig as calibrated, with lens distortion.
  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] const std::vector<RecordedImage>& color_images() const { return color_; }
  [[nodiscard]] const std::vector<RecordedImage>& depth_images() const { return depth_; }
  /// T_world_color over time, where groundtruth.txt is there.
  [[nodiscard]] const std::optional<Trajectory>& ground_truth() const { return ground_truth_; }

  /// As recorded: with lens distortion, depth in metres. An image of another size than the rig's is an error.
  [[nodiscard]] Result<RgbdFrame> read_frame(int index) const;
  [[nodiscard]] Result<ColorFrame> read_color(int index) const;

 private:
  Rig rig_;
  std::filesystem::path folder_;
  std::vector<RecordedImage> color_;
  std::vector<RecordedImage> depth_;
  std::optional<Trajectory> ground_truth_;
};

/// Writes a recording, image by image; the lists are complete after each one, so that a killed recorder leaves a
/// recording that can be read.
class RecordingWriter {
 public:
  static Result<RecordingWriter> create(const std::filesystem::path& folder, const Rig& rig);

  Status add_color(double timestamp_s, const ColorImage& image);
  Status add_depth(double timestamp_s, const DepthImage& image_m);
  Status add_ground_truth(double timestamp_s, const Pose& T_world_color);

 private:
  Rig rig_;
  std::filesystem::path folder_;
};

[[nodiscard]] Result<Rig> read_rig(const std::filesystem::path& file);
[[nodiscard]] Status write_rig(const std::filesystem::path& file, const Rig& rig);

}  // namespace meshloop
