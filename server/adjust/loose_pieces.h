#pragma once
#include <cstddef>
#include <vector>

#include "common/change/region.h"
#include "common/mesh/submesh.h"
#include "server/adjust/visible_surface.h"

namespace meshloop::adjust {

/// Noise leaves a rim of triangles where a removal ends at a silhouette. Pieces (triangles that share vertex positions)
/// of fewer than `smallest` triangles that touched the removed ones go with them, when all their vertices are in clear
/// sight: a small back side stays. `marks` holds the region that takes each triangle away, 0 for none; it is completed.
void take_loose_pieces(const Submesh& submesh, const std::vector<Sighting>& vertices, std::size_t smallest,
                       std::vector<RegionId>& marks);

}  // namespace meshloop::adjust
