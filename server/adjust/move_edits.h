#pragma once
// Moves as proposals and as edits.
#include "server/adjust/move_search.h"
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// Takes an id for a new node when only a part of the node moves. `along`: positions of the nodes that move with it.
[[nodiscard]] Proposal propose_move(const Snapshot& snapshot, const Part& part, const NewPlace& place,
                                    const std::vector<std::size_t>& along, NodeId& next_node_id);

/// Leaves out of removals what moves, and then removals of nothing.
void keep_what_moves(const std::map<NodeId, std::vector<bool>>& moving, std::vector<Removal>& removals);

/// What the accepted proposals ask of one node, together.
struct NodeChange {
  /// Removed triangles, and those that move elsewhere.
  std::optional<Removal> taken;
  /// Of `taken`: only moved away.
  std::size_t moved_away = 0;
  std::optional<Pose> T_world_node;
};

/// Refuses moves that were made for another revision, and what contradicts: a triangle that moves twice, or that is to
/// go as well.
[[nodiscard]] Result<std::map<NodeId, NodeChange>> add_moves(const Model& model, const std::vector<Proposal>& accepted,
                                                             const std::map<NodeId, Removal>& removals);

}  // namespace meshloop::adjust
