#pragma once
#include "common/implicit/shape.h"
#include "common/mesh/submesh.h"

namespace meshloop {

struct Tessellation {
  Submesh submesh;
  /// The largest distance from the corners and middles of triangles and edges to the solid's surface, and from some
  /// hundred points of each primitive's part of that surface to the nearest corner less two cells, metres; measured.
  double error_m = 0;
};

/// A stand-in of triangles for a shape, where formulas cannot go: dual contouring on a grid of `cells` along the
/// longest side of its bounds, with each cell's vertex on the planes of the surface that crosses the cell, so that
/// edges stay sharp. What is thinner than a cell may be missing. The shape must be valid.
[[nodiscard]] Result<Tessellation> tessellate(const Shape& shape, int cells = 96);

}  // namespace meshloop
