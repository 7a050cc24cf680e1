#pragma once
// A few triangles of a large mesh, with vertices of their own. Used inside this room.
#include <span>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

struct LocalMesh {
  /// The number that each vertex has in the large mesh.
  std::vector<std::uint32_t> vertices;
  std::vector<Eigen::Vector3f> positions;
  std::vector<Triangle> triangles;

  [[nodiscard]] Triangle outside(const Triangle& triangle) const {
    return {vertices[triangle[0]], vertices[triangle[1]], vertices[triangle[2]]};
  }
};

[[nodiscard]] LocalMesh make_local(const std::vector<Eigen::Vector3f>& positions, std::span<const Triangle> triangles);

}  // namespace meshloop
