#pragma once
#include "common/mesh/submesh.h"

namespace meshloop {

/// Vertices with exactly the same position and colour become one; those that nothing uses are dropped. Triangles keep
/// their number and order. The submesh must be valid.
[[nodiscard]] Submesh welded(Submesh submesh);

}  // namespace meshloop
