#include "server/adjust/proposal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "server/adjust/color_lookup.h"
#include "server/adjust/patch.h"
#include "server/adjust/removal.h"

namespace meshloop {
namespace {

std::string effect_of(const Proposal& proposal) {
  const bool adds = proposal.kind == ChangeKind::insertion;
  const auto triangles =
      adds ? fmt::format("+{}", proposal.triangles_added) : fmt::format("-{}", proposal.triangles_removed);
  if (proposal.largest_change_m == 0) return triangles + " triangles, where the model had none";
  return fmt::format("{} triangles; largest change {:.0f} mm", triangles, proposal.largest_change_m * 1000);
}

Proposal start_proposal(const Region& region) {
  Proposal proposal;
  proposal.id = region.id;
  proposal.kind = region.kind;
  proposal.largest_change_m = std::isfinite(region.max_difference_m) ? std::abs(region.max_difference_m) : 0;
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

Proposal propose_removal(const Region& region, const Model& model, adjust::RemovedTriangles removed) {
  Proposal proposal = start_proposal(region);
  for (const auto& [id, mask] : removed) {
    const Node* node = model.find(id);
    if (node == nullptr) continue;
    proposal.edits.push_back(adjust::removal_edit(*node, mask));
    proposal.triangles_removed += static_cast<std::size_t>(std::count(mask.begin(), mask.end(), true));
  }
  proposal.removed = std::move(removed);
  proposal.effect = effect_of(proposal);
  return proposal;
}

using Masks = std::map<NodeId, std::vector<bool>>;

Status add_masks(const Model& model, const Proposal& proposal, Masks& masks) {
  for (const auto& [id, mask] : proposal.removed) {
    const Node* node = model.find(id);
    if (node == nullptr || node->submesh->triangles.size() != mask.size()) {
      return fail(
          fmt::format("proposal {} was made for another revision of node {}; take a new snapshot", proposal.id, id));
    }
    auto& all = masks[id];
    if (all.empty()) all.assign(mask.size(), false);
    for (std::size_t t = 0; t < mask.size(); ++t) all[t] = all[t] || mask[t];
  }
  return {};
}

}  // namespace

std::vector<Proposal> propose(const Snapshot& snapshot, NodeId next_node_id, const AdjustOptions& options) {
  if (!adjust::validate(snapshot)) return {};
  const adjust::ColorLookup colors{snapshot};
  auto removed = adjust::find_removed(snapshot, options);
  std::vector<Proposal> proposals;
  for (const auto& region : snapshot.regions->regions) {
    if (!region.confirmed || region.kind == ChangeKind::none) continue;
    auto proposal =
        region.kind == ChangeKind::insertion
            ? propose_insertion(region, adjust::make_patch(snapshot, region.id, options, colors), next_node_id)
            : propose_removal(region, *snapshot.model, std::move(removed[region.id]));
    if (!proposal.edits.empty()) proposals.push_back(std::move(proposal));
  }
  return proposals;
}

Result<std::vector<Edit>> merge_edits(const Model& model, const std::vector<Proposal>& accepted) {
  Masks masks;
  std::vector<Edit> edits;
  std::set<NodeId> added;
  for (const auto& proposal : accepted) {
    if (auto ok = add_masks(model, proposal, masks); !ok) return fail(ok.error());
    for (const auto& edit : proposal.edits) {
      const auto* addition = std::get_if<AddNode>(&edit);
      if (addition == nullptr) continue;
      if (model.find(addition->node.id) != nullptr || !added.insert(addition->node.id).second) {
        return fail(fmt::format("proposal {} adds node {}, which is there already; take a new snapshot", proposal.id,
                                addition->node.id));
      }
      edits.push_back(edit);
    }
  }
  for (const auto& [id, mask] : masks) edits.push_back(adjust::removal_edit(*model.find(id), mask));
  return edits;
}

}  // namespace meshloop
