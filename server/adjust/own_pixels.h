#pragma once
#include <vector>

#include "server/adjust/visible_surface.h"

namespace meshloop::adjust {

/// Takes back marks of triangles that only touch what goes. Corners say which triangles may go: but a corner that lies
/// on what goes, or at a silhouette before it, is seen through whatever it belongs to. So the measured pixels decide in
/// which the triangles themselves are seen. A triangle stays when less than half of its own are seen through; and so
/// does a whole piece, marked triangles that hang together, of whose pixels less than half are. A triangle without such
/// a pixel, too thin, too far or not measured, goes only when all its corners are seen through.
///
/// `corners` has what was seen of each vertex of the node, `marks` the region that takes each of its triangles away, 0
/// for none.
void keep_what_only_touches(const Snapshot& snapshot, const VisibleSurface& surface, std::size_t node_position,
                            const std::vector<Sighting>& corners, std::vector<RegionId>& marks);

}  // namespace meshloop::adjust
