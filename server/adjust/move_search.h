#pragma once
// The new place of one part.
#include <optional>

#include "server/adjust/color_lookup.h"
#include "server/adjust/move_check.h"
#include "server/adjust/without_part.h"

namespace meshloop::adjust {

struct NewPlace {
  Pose T_camera_node;
  MoveCheck check;
  /// 0 to 1: the share of the measurements that it explains, less where it might as well be turned otherwise.
  double confidence = 0;
};

/// Nothing when the part is not found, or at more than one place.
[[nodiscard]] std::optional<NewPlace> find_new_place(const MoveScene& scene, const Part& part,
                                                     const WithoutPart& without, const ColorLookup& colors);

}  // namespace meshloop::adjust
