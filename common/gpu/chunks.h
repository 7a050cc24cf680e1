#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// Triangles that lie near each other, consecutive in an index buffer, which are drawn or left out together.
struct Chunk {
  /// Positions in the index buffer.
  int first_index = 0;
  int index_count = 0;
  /// In the submesh's frame.
  Eigen::AlignedBox3f bounds;
};

struct ChunkedTriangles {
  /// The submesh's triangles in another order.
  std::vector<Triangle> triangles;
  std::vector<Chunk> chunks;
};

/// Sorts along a space-filling curve and cuts into chunks of at most 512 triangles. The submesh must be valid.
[[nodiscard]] ChunkedTriangles make_chunks(const Submesh& submesh);

}  // namespace meshloop
