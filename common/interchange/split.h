#pragma once
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// The submesh in pieces of at most `max_triangles` (at least 1); whole where it has no more. What hangs together, by
/// vertices in one place, and has at least 500 triangles is a piece of its own (the 32 largest), so that what can move
/// is in one; the rest is halved in space at the median of the triangles' centres along the longest axis. Vertices on a
/// cut are in both pieces, with the same bits.
[[nodiscard]] std::vector<Submesh> split(const Submesh& submesh, std::size_t max_triangles);

}  // namespace meshloop
