#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "common/change/region.h"
#include "common/mesh/submesh.h"

namespace meshloop::adjust {

/// Noise leaves a rim of triangles where a removal ends at a silhouette. Pieces (triangles that share vertex positions)
/// of fewer than `smallest` triangles that touched the removed ones go with them, when all their corners and centres
/// are in clear sight (`in_sight` says so for a triangle's position in the list): a small back side stays. `marks`
/// holds the region that takes each triangle away, 0 for none; it is completed.
void take_loose_pieces(const Submesh& submesh, const std::function<bool(std::size_t)>& in_sight, std::size_t smallest,
                       std::vector<RegionId>& marks);

}  // namespace meshloop::adjust
