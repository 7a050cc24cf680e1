#pragma once
#include <cstddef>

#include "server/adjust/proposal.h"

namespace meshloop::adjust {

struct CutSubmesh {
  /// May have no triangles.
  Submesh submesh;
  /// Triangles of the original that are gone, or were cut.
  std::size_t taken = 0;
  /// Triangles that fill what is left of those that were cut.
  std::size_t added = 0;
};

/// Takes the removal's triangles and parts of triangles away. What no line touches keeps its bits and its order and
/// comes first; new corners lie on the scene's lattice, and where two triangles share an edge both get the same ones,
/// so that no crack opens. Colours are interpolated.
[[nodiscard]] CutSubmesh cut(const Submesh& submesh, const Removal& removal);

}  // namespace meshloop::adjust
