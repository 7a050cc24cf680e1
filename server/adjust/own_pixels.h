#pragma once
#include <vector>

#include "server/adjust/visible_surface.h"

namespace meshloop::adjust {

/// Takes back marks of triangles that only touch what goes. Corners say which triangles may go: but a corner that lies
/// on what goes, or at a silhouette before it, is seen through whatever it belongs to. So the pixels decide in which
/// the triangles themselves are seen: a triangle stays when less than half of its own are seen through, and so does
/// all that hangs together with marked triangles of which that is true as a whole. What is too thin or too far for a
/// pixel of its own goes with what it hangs together with, when all its corners are seen through.
///
/// `corners` has what was seen of each vertex of the node, `marks` the region that takes each of its triangles away, 0
/// for none. The triangles `others` are drawn too, since they hide what lies behind them, and are never changed.
void keep_what_only_touches(const Snapshot& snapshot, const VisibleSurface& surface, std::size_t node_position,
                            const std::vector<Sighting>& corners, const std::vector<bool>& others,
                            std::vector<RegionId>& marks);

}  // namespace meshloop::adjust
