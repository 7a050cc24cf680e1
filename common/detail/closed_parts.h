#pragma once
// Parts of a surface that enclose space: who looks at one from outside sees no triangle that faces away. Used inside
// this room.
#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

struct ClosedParts {
  /// By vertex the part of all its triangles; kNone for vertices of open parts, and where two parts touch.
  std::vector<std::int32_t> of_vertex;
  std::vector<Eigen::AlignedBox3f> bounds;

  static constexpr std::int32_t kNone = -1;
};

/// A part is what hangs together at edges. It is closed when each of its edges is run through as often in one direction
/// as in the other. It faces outwards when lines through it, up to 48 x 48 along each axis, go in before they go out.
/// Parts of less than 64 triangles are not looked for. Vertices at one place must be one vertex; a triangle that names
/// one twice opens its part.
[[nodiscard]] ClosedParts closed_parts_of(const std::vector<Eigen::Vector3f>& positions,
                                          std::span<const Triangle> triangles);

}  // namespace meshloop
