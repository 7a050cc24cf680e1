#pragma once
// Recordings: folders in the TUM RGB-D layout with a rig.yaml (see the folder's README).
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
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
  [[nodiscard]] static Result<Recording> open(const std::filesystem::path& folder);
  /// The same with another rig file.
  [[nodiscard]] static Result<Recording> open(const std::filesystem::path& folder,
                                              const std::filesystem::path& rig_file);

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
  Recording() = default;
  [[nodiscard]] Result<ColorImage> read_color_file(const RecordedImage& image) const;
  [[nodiscard]] Result<DepthImage> read_depth_file(const RecordedImage& image) const;

  Rig rig_;
  std::filesystem::path folder_;
  std::vector<RecordedImage> color_;
  std::vector<RecordedImage> depth_;
  std::optional<Trajectory> ground_truth_;
};

/// How a recording keeps its depth images: PNG is rounded to the rig's depth_scale, TIFF keeps each float.
enum class DepthFormat { png16, float_tiff };

/// Writes a recording, image by image; the lists are complete after each one, so that a killed recorder leaves a
/// recording that can be read. Images must have the rig's sizes, and timestamps must grow in each list.
class RecordingWriter {
 public:
  /// Makes the folder. Refuses one that holds a recording already.
  [[nodiscard]] static Result<RecordingWriter> create(const std::filesystem::path& folder, const Rig& rig,
                                                      DepthFormat depth_format = DepthFormat::png16);

  [[nodiscard]] Status add_color(double timestamp_s, const ColorImage& image);
  /// Metres, kept in units of the rig's depth_scale. What is no depth (negative, NaN), and what a 16-bit PNG cannot
  /// hold, becomes 0 (unmeasured).
  [[nodiscard]] Status add_depth(double timestamp_s, const DepthImage& image_m);
  [[nodiscard]] Status add_ground_truth(double timestamp_s, const Pose& T_world_color);

 private:
  /// One list file, and how far it has come.
  struct Stream {
    std::string name;
    int count = 0;
    double last_s = 0;
  };

  RecordingWriter(Rig rig, std::filesystem::path folder, DepthFormat depth_format)
      : rig_{std::move(rig)}, folder_{std::move(folder)}, depth_format_{depth_format} {}
  [[nodiscard]] Status check_time(const Stream& stream, double timestamp_s) const;
  [[nodiscard]] Status append(Stream& stream, double timestamp_s, const std::string& header, const std::string& line);
  template <class Write>
  [[nodiscard]] Status add_image(Stream& stream, double timestamp_s, const char* ending, Write write);

  Rig rig_;
  std::filesystem::path folder_;
  DepthFormat depth_format_;
  Stream color_{"rgb"};
  Stream depth_{"depth"};
  Stream ground_truth_{"groundtruth"};
};

/// rig.yaml. Every key must be there, none may be unknown; a registered depth camera must equal the colour camera.
[[nodiscard]] Result<Rig> read_rig(const std::filesystem::path& file);
[[nodiscard]] Status write_rig(const std::filesystem::path& file, const Rig& rig);
/// What write_rig writes. Of a valid rig.
[[nodiscard]] std::string rig_text(const Rig& rig);

}  // namespace meshloop
