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

/// Takes parts out of one large mesh; what a part costs does not depend on the size of the whole.
class PartCutter {
 public:
  /// The positions must outlive it.
  explicit PartCutter(const std::vector<Eigen::Vector3f>& positions);
  /// Vertices are numbered in the order in which the triangles name them.
  [[nodiscard]] LocalMesh take(std::span<const Triangle> triangles);

 private:
  const std::vector<Eigen::Vector3f>& positions_;
  std::vector<std::uint32_t> number_of_;
};

}  // namespace meshloop
