#include "server/adjust/proposal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <set>

#include "server/adjust/color_lookup.h"
#include "server/adjust/find_moves.h"
#include "server/adjust/move_edits.h"
#include "server/adjust/patch.h"
#include "server/adjust/proposal_place.h"
#include "server/adjust/removal.h"
#include "server/adjust/see_through.h"

namespace meshloop {
namespace {

std::string triangles_text(char sign, std::size_t count) {
  return fmt::format("{}{} triangle{}", sign, count, count == 1 ? "" : "s");
}

std::string effect_of(const Proposal& proposal) {
  std::string triangles;
  if (proposal.triangles_removed > 0) triangles = triangles_text('-', proposal.triangles_removed);
  if (proposal.triangles_removed > 0 && proposal.triangles_added > 0) {
    triangles += fmt::format(", +{}", proposal.triangles_added);
  } else if (proposal.triangles_added > 0) {
    triangles = triangles_text('+', proposal.triangles_added);
  }
  const auto change = proposal.largest_change_m == 0
                          ? std::string{", where the model had none"}
                          : fmt::format("; largest change {:.0f} mm", proposal.largest_change_m * 1000);
  return fmt::format("{}{}; closes region {}", triangles, change, proposal.closes.front());
}

Proposal start_proposal(const Region& region) {
  Proposal proposal;
  proposal.id = region.id;
  proposal.kind = region.kind;
  proposal.largest_change_m = std::isfinite(region.max_difference_m) ? std::abs(region.max_difference_m) : 0;
  proposal.confidence = std::erf(std::max(region.significance, 0.0) / std::numbers::sqrt2);
  proposal.closes = {region.id};
  return proposal;
}

Proposal propose_insertion(const Region& region, Submesh patch, NodeId& next_node_id) {
  Proposal proposal = start_proposal(region);
  if (!validate(patch)) return proposal;
  proposal.triangles_added = patch.triangles.size();
  auto pieces = adjust::split(std::move(patch), adjust::kMaxPatchTriangles);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto name = pieces.size() == 1 ? fmt::format("patch {}", next_node_id)
                                         : fmt::format("patch {} ({} of {})", next_node_id, i + 1, pieces.size());
    proposal.edits.emplace_back(AddNode{make_node(next_node_id++, name, std::move(pieces[i]))});
  }
  proposal.effect = effect_of(proposal);
  return proposal;
}

Proposal propose_removal(const Region& region, const Snapshot& snapshot, std::vector<Removal> removals) {
  const Model& model = *snapshot.model;
  Proposal proposal = start_proposal(region);
  for (auto& removal : removals) {
    adjust::Removed removed = adjust::remove_from(*model.find(removal.node), removal);
    if (!removed.edit) continue;
    proposal.edits.push_back(std::move(*removed.edit));
    proposal.triangles_removed += removed.taken;
    proposal.triangles_added += removed.added;
    proposal.removed.push_back(std::move(removal));
  }
  if (proposal.edits.empty()) return proposal;
  proposal.see_through = adjust::look_through(snapshot, proposal.removed);
  proposal.confidence = proposal.see_through->share();
  proposal.effect = effect_of(proposal);
  return proposal;
}

using Removals = std::map<NodeId, Removal>;

Status add_removals(const Model& model, const Proposal& proposal, Removals& removals) {
  for (const auto& removal : proposal.removed) {
    const Node* node = model.find(removal.node);
    if (node == nullptr || node->hash != removal.hash || !node->T_world_node.isApprox(removal.T_world_node, 1e-9)) {
      return fail(fmt::format("proposal {} was made for another revision of node {}; take a new snapshot", proposal.id,
                              removal.node));
    }
    const auto [entry, is_first] = removals.try_emplace(removal.node, removal);
    if (is_first) continue;
    Removal& all = entry->second;
    for (std::size_t t = 0; t < all.triangles.size(); ++t) all.triangles[t] = all.triangles[t] || removal.triangles[t];
    for (const auto& [t, lines] : removal.cuts) {
      auto& lines_of_triangle = all.cuts[t];
      lines_of_triangle.insert(lines_of_triangle.end(), lines.begin(), lines.end());
    }
  }
  return {};
}

// One for each confirmed region. `moving` stays out of removals.
std::vector<Proposal> propose_regions(const Snapshot& snapshot, const std::map<NodeId, std::vector<bool>>& moving,
                                      const adjust::ColorLookup& colors, NodeId& next_node_id,
                                      const AdjustOptions& options) {
  auto removed = adjust::find_removed(snapshot, options);
  for (auto& [region, removals] : removed) adjust::keep_what_moves(moving, removals);
  std::vector<Proposal> proposals;
  for (const auto& region : snapshot.regions->regions) {
    if (!region.confirmed || region.kind == ChangeKind::none) continue;
    auto proposal =
        region.kind == ChangeKind::insertion
            ? propose_insertion(region, adjust::make_patch(snapshot, region.id, options, colors), next_node_id)
            : propose_removal(region, snapshot, std::move(removed[region.id]));
    if (proposal.edits.empty()) continue;
    proposal.box_m = adjust::place_of(*snapshot.model, proposal);
    proposals.push_back(std::move(proposal));
  }
  return proposals;
}

}  // namespace

std::vector<Proposal> propose(const Snapshot& snapshot, NodeId next_node_id, const AdjustOptions& options) {
  if (!adjust::validate(snapshot)) return {};
  const adjust::ColorLookup colors{snapshot};
  if (!options.moves) return propose_regions(snapshot, {}, colors, next_node_id, options);
  auto found = adjust::find_moves(snapshot, colors, next_node_id);
  Snapshot rest = snapshot;
  if (!found.proposals.empty()) rest.regions = &found.left;
  auto others = propose_regions(rest, found.moving, colors, next_node_id, options);
  std::move(others.begin(), others.end(), std::back_inserter(found.proposals));
  return std::move(found.proposals);
}

Result<MergedEdits> merge_edits(const Model& model, const std::vector<Proposal>& accepted) {
  Removals removals;
  MergedEdits merged;
  std::set<NodeId> added;
  for (const auto& proposal : accepted) {
    if (auto ok = add_removals(model, proposal, removals); !ok) return fail(ok.error());
    for (const auto& edit : proposal.edits) {
      const auto* addition = std::get_if<AddNode>(&edit);
      if (addition == nullptr) continue;
      if (model.find(addition->node.id) != nullptr || !added.insert(addition->node.id).second) {
        return fail(fmt::format("proposal {} adds node {}, which is there already; take a new snapshot", proposal.id,
                                addition->node.id));
      }
      merged.edits.push_back(edit);
      if (!proposal.move) merged.triangles_added += addition->node.submesh->triangles.size();
    }
  }
  const auto changes = adjust::add_moves(model, accepted, removals);
  if (!changes) return fail(changes.error());
  for (const auto& [id, change] : *changes) {
    if (change.T_world_node) merged.edits.emplace_back(MoveNode{id, *change.T_world_node});
    if (!change.taken) continue;
    auto removed = adjust::remove_from(*model.find(id), *change.taken);
    if (!removed.edit) continue;
    merged.edits.push_back(std::move(*removed.edit));
    merged.triangles_added += removed.added;
    merged.triangles_removed += removed.taken - change.moved_away;
  }
  return merged;
}

}  // namespace meshloop
