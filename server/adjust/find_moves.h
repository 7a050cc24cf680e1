#pragma once
// What did not come and go, but moved.
#include <map>
#include <vector>

#include "server/adjust/color_lookup.h"
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

struct FoundMoves {
  std::vector<Proposal> proposals;
  /// The snapshot's regions without the pixels that the moves explain; closed regions are not there any more.
  RegionMap left;
  /// By node: the triangles that move.
  std::map<NodeId, std::vector<bool>> moving;
};

/// The snapshot must be valid. `next_node_id` is the first free id; parts of nodes that move take consecutive ones.
[[nodiscard]] FoundMoves find_moves(const Snapshot& snapshot, const ColorLookup& colors, NodeId& next_node_id);

}  // namespace meshloop::adjust
