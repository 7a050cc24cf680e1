#pragma once
#include <filesystem>
#include <functional>

#include "common/base/result.h"

namespace meshloop::simulation {

struct DemoOptions {
  /// 1: a Kinect's noise; 0: none.
  double noise = 1;
  unsigned seed = 1;
  /// Frames of the station's recording (both halves together) and of each recording of the device.
  int station_frames = 120;
  int device_frames = 180;
};

/// Writes below `folder`:
///   model.ply            the modelled solids, with vertex colours
///   model_before_move.ply  all solids, the box at its first place: a perfect model of the scene's first half
///   markers.yaml         the markers on the sideboard
///   station/             depth and colour recording; in its second half the box stands 2 cm away from where it was
///   station_truth/       per depth frame: expected_NNNNNN.tiff (exact depth of the model at the start),
///   measured_NNNNNN.tiff
///                        (exact depth of the scene), previous_NNNNNN.tiff (exact depth of the scene with the box at
///                        its first place; second half only)
///   device_before_move/, device_after_move/   colour recordings on a circle around the scene, box at its first and
///   second
///                        place, with groundtruth.txt
/// Calls progress(done, all) from time to time.
[[nodiscard]] Status write_demo_data(const std::filesystem::path& folder, const DemoOptions& options,
                                     const std::function<void(int, int)>& progress);

}  // namespace meshloop::simulation
