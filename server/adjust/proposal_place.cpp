#include "server/adjust/proposal_place.h"

namespace meshloop::adjust {
namespace {

void extend(Eigen::AlignedBox3d& box, const Submesh& submesh, const Triangle& triangle, const Pose& T_world_node) {
  for (const auto corner : triangle) box.extend(T_world_node * submesh.positions[corner].cast<double>());
}

void extend(Eigen::AlignedBox3d& box, const Submesh& submesh, const Pose& T_world_node) {
  for (const auto& p : submesh.positions) box.extend(T_world_node * p.cast<double>());
}

void extend_by_removed(Eigen::AlignedBox3d& box, const Submesh& submesh, const Removal& removal) {
  for (std::size_t t = 0; t < removal.triangles.size(); ++t) {
    if (removal.triangles[t]) extend(box, submesh, submesh.triangles[t], removal.T_world_node);
  }
  for (const auto& [triangle, lines] : removal.cuts) {
    for (const auto& line : lines) {
      for (const auto& p : line) box.extend(removal.T_world_node * p);
    }
  }
}

}  // namespace

Eigen::AlignedBox3d place_of(const Model& model, const Move& move, const Pose& T_world_old) {
  Eigen::AlignedBox3d box;
  const Submesh& submesh = *model.find(move.node)->submesh;
  for (std::size_t t = 0; t < move.triangles.size(); ++t) {
    if (move.triangles[t]) extend(box, submesh, submesh.triangles[t], T_world_old * move.T_world_node);
  }
  for (const auto& other : move.along) extend(box, *model.find(other.node)->submesh, T_world_old * other.T_world_node);
  return box;
}

Eigen::AlignedBox3d place_of(const Model& model, const Proposal& proposal) {
  if (proposal.move) return proposal.move->box_old_m.merged(proposal.move->box_new_m);
  Eigen::AlignedBox3d box;
  for (const auto& removal : proposal.removed) extend_by_removed(box, *model.find(removal.node)->submesh, removal);
  if (!proposal.removed.empty()) return box;
  for (const auto& edit : proposal.edits) {
    if (const auto* added = std::get_if<AddNode>(&edit)) extend(box, *added->node.submesh, added->node.T_world_node);
  }
  return box;
}

}  // namespace meshloop::adjust
