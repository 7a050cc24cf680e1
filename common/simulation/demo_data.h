#pragma once
#include <filesystem>
#include <functional>

#include "common/base/result.h"

namespace meshloop::simulation {

/// The rig that is simulated. Pictures of other sizes keep the Kinect's horizontal angle of view.
struct DemoRig {
  struct Size {
    int width = 640;
    int height = 480;
  };
  Size color;
  Size depth;
  /// Depth lies in the colour camera's pixels, and has its size whatever `depth` says.
  bool registered = false;
  /// 32-bit float TIFF in metres in place of 16-bit PNG.
  bool float_depth = false;
};

struct DemoOptions {
  /// 1: a Kinect's noise; 0: none.
  double noise = 1;
  unsigned seed = 1;
  /// Frames of the station's recording (both halves together) and of each recording of the device.
  int station_frames = 120;
  int device_frames = 120;
  DemoRig rig;
};

/// Writes below `folder`:
///   model.ply              the modelled solids, with vertex colours
///   model_before_move.ply  all solids, the box at its first place: a perfect model of the scene's first half
///   markers.yaml           the markers on the sideboard
///   station/               depth and colour; in its second half the box stands 2 cm away from where it was.
///                          groundtruth.txt holds a pose for every colour and every depth timestamp
///   station_truth/         for each depth frame, exact depth: expected_NNNNNN.tiff of the model at the start,
///                          measured_NNNNNN.tiff of the scene, and in the second half previous_NNNNNN.tiff of the
///                          scene with the box at its first place; frames.txt with times and poses
///   device/                colour on a circle around the box, which stands at its second place, with groundtruth.txt
///   device_before_move/    colour on a nearer way around the box, which stands at its first place; the same files
///   device_after_move/     the same way, the box at its second place
/// Refuses a folder that holds such recordings already. Calls progress(done, all) after each frame, from any thread,
/// one at a time.
[[nodiscard]] Status write_demo_data(const std::filesystem::path& folder, const DemoOptions& options,
                                     const std::function<void(int, int)>& progress);

}  // namespace meshloop::simulation
