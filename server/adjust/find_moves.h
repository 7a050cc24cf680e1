#pragma once
// What did not come and go, but moved.
#include <map>
#include <vector>

#include "server/adjust/color_lookup.h"
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

struct FoundMoves {
  std::vector<Proposal> proposals;
  /// The snapshot's regions without the pixels that the moves explain, if 60 or more (at 640x480) are left. What is
  /// left of a closed region has an id that no region of the snapshot has.
  RegionMap left;
  /// By node: the triangles that move.
  std::map<NodeId, std::vector<bool>> moving;
};

/// The snapshot must be valid. `next_node_id` is the first free id; parts of nodes that move take consecutive ones.
[[nodiscard]] FoundMoves find_moves(const Snapshot& snapshot, const ColorLookup& colors, NodeId& next_node_id);

}  // namespace meshloop::adjust
