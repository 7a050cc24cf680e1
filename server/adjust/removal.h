#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// What the confirmed removal regions take away, by region. The snapshot must be valid.
[[nodiscard]] std::map<RegionId, std::vector<Removal>> find_removed(const Snapshot& snapshot,
                                                                    const AdjustOptions& options);

/// What a removal makes of a node.
struct Removed {
  /// None when nothing changes.
  std::optional<Edit> edit;
  /// Triangles that are gone, or were cut.
  std::size_t taken = 0;
  /// Triangles that fill what is left of those that were cut.
  std::size_t added = 0;
};

/// The node with its submesh cut, or without it. The removal must fit the node's submesh.
[[nodiscard]] Removed remove_from(const Node& node, const Removal& removal);

}  // namespace meshloop::adjust
