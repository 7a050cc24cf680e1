#pragma once
// The picture with a part of the model taken away.
#include <cstdint>
#include <vector>

#include "server/adjust/move_scene.h"

namespace meshloop::adjust {

/// Measured surface that hangs together, in front of all that the model has left.
struct LoosePiece {
  int pixels = 0;
  /// Mean of its points, in the camera's frame.
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Window window;
};

struct WithoutPart {
  /// Where the part is expected to be seen, at its old place.
  DepthBuffer old_place;
  /// Only these pixels of `old_place` show it; 0 or 1, like its rows.
  std::vector<std::uint8_t> footprint;
  int footprint_pixels = 0;
  /// What the rest of the model shows; 0 where it shows nothing. In the camera's size, as are the next three.
  DepthImage background;
  Image<std::uint32_t> node_index;
  Image<float> threshold_m;
  /// Position in `pieces` plus 1, for what is measured nearer than the background; 0 elsewhere.
  Image<std::uint32_t> piece;
  std::vector<LoosePiece> pieces;

  [[nodiscard]] bool in_footprint(int x, int y) const {
    return old_place.contains(x, y) && footprint[old_place.at(x, y)] != 0;
  }
};

[[nodiscard]] WithoutPart take_away(const MoveScene& scene, const Part& part);

}  // namespace meshloop::adjust
