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
  /// By vertex the part it belongs to, or kNone.
  std::vector<std::int32_t> of_vertex;
  std::vector<Eigen::AlignedBox3f> bounds;

  static constexpr std::int32_t kNone = -1;
};

/// A part is what hangs together at vertices. It is closed when every edge is run through as often in one direction as
/// in the other, and faces outwards when its signed volume is positive. Vertices at one place must be one vertex.
[[nodiscard]] ClosedParts closed_parts_of(const std::vector<Eigen::Vector3f>& positions,
                                          std::span<const Triangle> triangles);

}  // namespace meshloop
