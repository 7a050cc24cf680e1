#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop::adjust {

/// Where parts of a surface touch in a vertex only, each gets a vertex of its own in the same place, so that borders do
/// not meet. `border` has the directed edges of all borders of the submesh, and is changed with it.
void split_vertices(Submesh& submesh, std::vector<std::array<std::uint32_t, 2>>& border);

}  // namespace meshloop::adjust
