#pragma once
// What belongs to a thing that moved, and moves with it.
#include <vector>

#include "server/adjust/move_search.h"

namespace meshloop::adjust {

struct AlongPart {
  Part part;
  NewPlace place;
  WithoutPart without;
};

/// Whether a whole node belongs to a part that was found at `place`: all but strays of it lies within the part's box,
/// and at the same way from it nothing that is measured speaks against it. The patches of one thing, made from several
/// snapshots, do; its back, which this snapshot does not show, too. Nothing when it does not.
[[nodiscard]] std::optional<AlongPart> moves_along(const MoveScene& scene, const Part& part, const NewPlace& place,
                                                   std::size_t node_position);

}  // namespace meshloop::adjust
