#pragma once
// Options that several subcommands of the station share.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "common/change/comparison.h"
#include "server/adjust/proposal.h"
#include "server/pipeline/examiner.h"
#include "server/pipeline/tracked_frames.h"

namespace meshloop {

/// `--recording DIR [--rig F] [--sensor NAME] [--poses F] [--markers F] [--init pose:...]`
struct RecordingArguments {
  std::string recording;
  std::string rig;
  std::string sensor;
  std::string poses;
  std::string markers;
  std::string init;

  /// All options; without `poses_allowed` all but --poses.
  void add_to(CLI::App& command, bool poses_allowed);
  /// All options but --recording, for a command that names its source otherwise.
  void add_source_options(CLI::App& command);
  /// Opens the recording and decides where the poses come from: --poses, else --markers and --init, else the
  /// recording's groundtruth.txt (not for `track`, which makes poses). A batch stops at a frame that cannot be read, a
  /// `live` run goes on with the next one. `real_time`: frames come at the pace of their timestamps.
  [[nodiscard]] Result<TrackedFrames> open(bool live = false, bool real_time = false) const;

 private:
  bool poses_allowed_ = true;
};

/// `[--operator NAME]`: who the journal says it was.
struct OperatorArguments {
  /// The login name.
  OperatorArguments();
  std::string name;

  void add_to(CLI::App& command);
};

/// `[--fuse N] [--decimate SIGMAS] [--texture on|off] [--stitch on|off]`: how new surface is made.
struct SurfaceArguments {
  /// Frames of a snapshot.
  int fuse = 1;
  double decimate_sigmas = 0;
  std::string texture = "off";
  std::string stitch = "on";

  void add_to(CLI::App& command);
  [[nodiscard]] AdjustOptions adjust_options() const;
};

/// `[--threshold 0.02|3sigma] [--model-sigma METRES] [--exact]`: what counts as a change, and how exactly it is looked
/// for.
struct ThresholdArguments {
  std::string threshold = "3sigma";
  double model_sigma_m = 0;
  bool exact = false;

  void add_to(CLI::App& command);
  [[nodiscard]] Result<ExaminerOptions> examiner_options() const;
  /// "3sigma", "0.02 m"
  [[nodiscard]] std::string text() const;
};

/// What a batch command fails with that placed no frame.
inline constexpr const char* kEveryFrameIsLost =
    "every frame is lost; do the poses or markers fit the recording, and cover its time?";

/// A name of SensorModel::from_name, or `constant:METRES`.
[[nodiscard]] Result<SensorModel> parse_sensor(const std::string& text);
/// `0.02` (metres, at most 1) or `3sigma` (at most 100).
[[nodiscard]] Result<Threshold> parse_threshold(const std::string& text);

}  // namespace meshloop
