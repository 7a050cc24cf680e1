#pragma once
// Does a part at a new place explain what is measured, and is it there to be seen?
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/adjust/without_part.h"

namespace meshloop::adjust {

/// Shares from 0 to 1. Pixels beside an outline that can be of either surface count nowhere.
struct MoveCheck {
  /// Of the measured pixels that should show the part: they do.
  double agreeing = 0;
  /// They show something farther away.
  double seen_through = 0;
  /// Of the pixels that the part covers: they have a measurement.
  double measured = 0;
  /// How many those pixels are.
  double seen_px = 0;
  /// The model has something before it, or it is sunk into it.
  double hidden = 0;
  /// Of what faces the camera: it lies outside the picture.
  double outside = 0;
  /// Of the loose surface that the part touches: it is the part's.
  double explained = 0;
  /// Of the pixels of its old place that it left (at least a fiftieth of what is seen of it counts as left): the part
  /// is measured there still.
  double still_there = 0;
  /// Regions of which the part at its new place leaves at most a tenth.
  std::vector<RegionId> closes;

  /// What is expected with the part at its new place, in this window, row by row.
  Window window;
  std::vector<float> expected;
  std::vector<std::uint32_t> node_index;
  std::vector<float> threshold_m;
  /// 1 where a region's pixel is no longer a change of its kind.
  std::vector<std::uint8_t> is_explained;

  /// Of part and loose surface together: what does not fit, 0 for a perfect explanation.
  [[nodiscard]] double unexplained() const { return (1 - agreeing) + (1 - explained) + hidden; }
  /// Why this is no move; nothing when it is one.
  [[nodiscard]] std::optional<std::string> refusal() const;
};

/// Of what of a part faces the camera: the share that lies outside the picture.
[[nodiscard]] double share_outside(const MoveScene& scene, const Part& part, const Pose& T_camera_node);

[[nodiscard]] MoveCheck check_move(const MoveScene& scene, const Part& part, const WithoutPart& without,
                                   const Pose& T_camera_node);

}  // namespace meshloop::adjust
