#pragma once
// Which clusters are simplified together. Used inside this room.
#include <cstdint>
#include <span>
#include <vector>

#include "common/detail/working_cluster.h"

namespace meshloop {

/// Groups of at most `largest` clusters that share as many border edges as a greedy choice finds. Every cluster is in
/// one group. Positions in `clusters`.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> group_neighbours(std::span<const WorkingCluster> clusters,
                                                                       std::size_t largest);

}  // namespace meshloop
