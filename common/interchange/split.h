#pragma once
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// The submesh in pieces of at most `max_triangles` (at least 1), halved in space at the median of the triangles'
/// centres along the longest axis. Vertices on a cut are in both pieces, with the same bits.
[[nodiscard]] std::vector<Submesh> split_in_space(const Submesh& submesh, std::size_t max_triangles);

}  // namespace meshloop
