#pragma once
// Where the demo's cameras are at a moment.
#include "common/geometry/pose.h"

namespace meshloop::simulation {

/// A hand that carries the rig once around the scene, from the front to the left of who stands there: it rests at
/// five places and moves quickly between them.
struct StationPath {
  /// Seconds of one round.
  double round_s = 6;
  /// The two halves of the recording differ in height and in the hand's wobble.
  int half = 0;

  /// T_world_color `t_s` seconds after the round began; a little beyond its end is fine.
  [[nodiscard]] Pose at(double t_s) const;
};

/// A steady walk around the box, once in `round_s` seconds from the front, that comes nearer on its way.
struct DevicePath {
  double round_s = 6;
  double farthest_m = 1.15;
  double nearest_m = 1.15;

  [[nodiscard]] Pose at(double t_s) const;
};

}  // namespace meshloop::simulation
