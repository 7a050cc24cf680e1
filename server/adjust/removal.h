#pragma once
#include <map>
#include <utility>
#include <vector>

#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// For each node that loses triangles: which ones.
using RemovedTriangles = std::vector<std::pair<NodeId, std::vector<bool>>>;

/// The triangles that the confirmed removal regions take away, by region. The snapshot must be valid.
[[nodiscard]] std::map<RegionId, RemovedTriangles> find_removed(const Snapshot& snapshot, const AdjustOptions& options);

/// What is left of the node: a smaller submesh, or nothing of it.
[[nodiscard]] Edit removal_edit(const Node& node, const std::vector<bool>& removed);

}  // namespace meshloop::adjust
