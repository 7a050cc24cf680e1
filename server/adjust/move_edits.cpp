#include "server/adjust/move_edits.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "server/adjust/proposal_place.h"

namespace meshloop::adjust {
namespace {

double largest_way_m(const Part& part, const Pose& T_world_node, const Pose& T_world_new_old) {
  double largest = 0;
  for (const auto& p : part.submesh.positions) {
    const Eigen::Vector3d before = T_world_node * p.cast<double>();
    largest = std::max(largest, (T_world_new_old * before - before).norm());
  }
  return largest;
}

std::string listed(const std::vector<RegionId>& ids) {
  std::string text = ids.size() == 1 ? "region " : "regions ";
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const char* before = i == 0 ? "" : (i + 1 == ids.size() ? " and " : ", ");
    text += fmt::format("{}{}", before, ids[i]);
  }
  return text;
}

std::string effect_of(const Node& node, const Part& part, const Move& move) {
  const Eigen::Vector3d center = node.T_world_node * part.center;
  const double way_m = (move.T_world_new_old * center - center).norm();
  const double angle = Eigen::AngleAxisd{move.T_world_new_old.linear()}.angle() * 180 / std::numbers::pi;
  const std::size_t others = move.along.size();
  const std::string along = others == 0 ? "" : fmt::format(" and {} more node{}", others, others > 1 ? "s" : "");
  return fmt::format("moves {}\"{}\"{} by {:.0f} mm and {:.0f} degrees; closes {}",
                     move.new_node == 0 ? "" : "a part of ", node.name, along, 1000 * way_m, angle,
                     listed(move.closes));
}

Pose rigid(const Pose& pose) {
  return make_pose(pose.translation(), Eigen::Quaterniond{pose.linear()}.normalized());
}

void add_edits(const Node& node, const Part& part, Proposal& proposal) {
  const Move& move = *proposal.move;
  const Pose T_world_node = rigid(move.T_world_new_old * node.T_world_node);
  for (const auto& other : move.along) {
    proposal.edits.emplace_back(MoveNode{other.node, rigid(move.T_world_new_old * other.T_world_node)});
  }
  if (move.new_node == 0) {
    proposal.edits.emplace_back(MoveNode{node.id, T_world_node});
    return;
  }
  std::vector<bool> stays = part.triangles;
  stays.flip();
  proposal.edits.emplace_back(
      ReplaceSubmesh{node.id, std::make_shared<const Submesh>(keep_triangles(*node.submesh, stays))});
  proposal.edits.emplace_back(AddNode{
      make_node(move.new_node, fmt::format("{} part {}", node.name, move.new_node), part.submesh, T_world_node)});
}

Status check_revision(const Model& model, const Proposal& proposal) {
  std::vector<MovedAlong> all = proposal.move->along;
  all.push_back({proposal.move->node, proposal.move->hash, proposal.move->T_world_node});
  for (const auto& one : all) {
    const Node* node = model.find(one.node);
    if (node != nullptr && node->hash == one.hash && node->T_world_node.isApprox(one.T_world_node, 1e-9)) continue;
    return fail(fmt::format("proposal {} was made for another revision of node {}; take a new snapshot", proposal.id,
                            one.node));
  }
  return {};
}

bool contradicts(const Removal& removal, const std::vector<bool>& moving) {
  for (std::size_t t = 0; t < moving.size(); ++t) {
    if (moving[t] && removal.triangles[t]) return true;
  }
  return std::any_of(removal.cuts.begin(), removal.cuts.end(), [&](const auto& cut) { return moving[cut.first]; });
}

}  // namespace

Proposal propose_move(const Snapshot& snapshot, const Part& part, const NewPlace& place,
                      const std::vector<std::size_t>& along, NodeId& next_node_id) {
  const Node& node = snapshot.model->nodes[part.node_position];
  const Pose& T_camera_world = snapshot.refined_T_camera_world.value_or(snapshot.depth_pose.T_camera_world);
  Move move;
  move.node = node.id;
  move.hash = node.hash;
  move.T_world_node = node.T_world_node;
  move.triangles = part.triangles;
  move.new_node = part.is_whole_node ? 0 : next_node_id++;
  move.T_world_new_old = rigid(T_camera_world.inverse() * place.T_camera_node * node.T_world_node.inverse());
  move.confidence = place.confidence;
  move.closes = place.check.closes;
  for (const auto n : along) {
    const Node& other = snapshot.model->nodes[n];
    move.along.push_back({other.id, other.hash, other.T_world_node});
  }
  move.box_old_m = place_of(*snapshot.model, move, Pose::Identity());
  move.box_new_m = place_of(*snapshot.model, move, move.T_world_new_old);
  Proposal proposal;
  proposal.id = move.closes.front();
  proposal.largest_change_m = largest_way_m(part, node.T_world_node, move.T_world_new_old);
  proposal.effect = effect_of(node, part, move);
  proposal.confidence = move.confidence;
  proposal.closes = move.closes;
  proposal.move = std::move(move);
  proposal.box_m = place_of(*snapshot.model, proposal);
  add_edits(node, part, proposal);
  return proposal;
}

void keep_what_moves(const std::map<NodeId, std::vector<bool>>& moving, std::vector<Removal>& removals) {
  for (auto& removal : removals) {
    const auto found = moving.find(removal.node);
    if (found == moving.end()) continue;
    const std::vector<bool>& moves = found->second;
    for (std::size_t t = 0; t < moves.size(); ++t) removal.triangles[t] = removal.triangles[t] && !moves[t];
    std::erase_if(removal.cuts, [&](const auto& cut) { return moves[cut.first]; });
  }
  std::erase_if(removals, [](const Removal& removal) {
    return removal.cuts.empty() &&
           std::find(removal.triangles.begin(), removal.triangles.end(), true) == removal.triangles.end();
  });
}

Result<std::map<NodeId, NodeChange>> add_moves(const Model& model, const std::vector<Proposal>& accepted,
                                               const std::map<NodeId, Removal>& removals) {
  std::map<NodeId, NodeChange> changes;
  for (const auto& [id, removal] : removals) changes[id].taken = removal;
  for (const auto& proposal : accepted) {
    if (!proposal.move) continue;
    if (auto ok = check_revision(model, proposal); !ok) return fail(ok.error());
    const Move& move = *proposal.move;
    const auto refuse = [&](NodeId node) {
      return fail(
          fmt::format("proposal {} moves what another accepted one moves or removes (node {}); accept one of them",
                      proposal.id, node));
    };
    for (const auto& other : move.along) {
      NodeChange& along = changes[other.node];
      if (along.T_world_node || along.taken) return refuse(other.node);
      along.T_world_node = rigid(move.T_world_new_old * other.T_world_node);
    }
    NodeChange& change = changes[move.node];
    if (change.T_world_node || (change.taken && contradicts(*change.taken, move.triangles))) return refuse(move.node);
    if (move.new_node == 0) {
      change.T_world_node = rigid(move.T_world_new_old * move.T_world_node);
      continue;
    }
    if (!change.taken) {
      change.taken =
          Removal{move.node, move.hash, std::vector<bool>(move.triangles.size(), false), {}, move.T_world_node};
    }
    for (std::size_t t = 0; t < move.triangles.size(); ++t) {
      if (!move.triangles[t]) continue;
      change.taken->triangles[t] = true;
      ++change.moved_away;
    }
  }
  return changes;
}

}  // namespace meshloop::adjust
