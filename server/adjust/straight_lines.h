#pragma once
// The straight lines in which the flat parts of a patch meet each other, the model and the open.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/change/comparison.h"
#include "server/adjust/flat_parts.h"
#include "server/adjust/grid_mesh.h"

namespace meshloop::adjust {

/// Where vertices lie that are not at the middle of their pixel. All vectors as long as the grid's.
struct VertexPlaces {
  /// Column and row in the window, and depth in metres; depth 0 where the pixel's own place holds.
  std::vector<Eigen::Vector3f> places;
  /// Vertices with the same number lie on one straight line; 0: on none. kCornerOfLines: where several meet.
  std::vector<std::uint16_t> lines;
};

/// Moves pixels that lie beside the line in which two planes meet onto it, by at most a pixel, and one to the point in
/// which three do; and rim pixels beside a plane to where it reaches the model's surface, by at most 10 pixels.
[[nodiscard]] VertexPlaces meet_in_lines(const DepthGrid& grid, const FlatParts& parts, const Comparison& comparison);

/// Moves members (of `vertices`) at an open border of the mesh onto the straight lines around all members, by at most
/// what noise makes a border ragged. What would turn a triangle over stays where it was.
void straighten_border(const DepthGrid& grid, const FlatParts& parts, const GridMesh& mesh,
                       const GridVertices& vertices, VertexPlaces& places);

}  // namespace meshloop::adjust
