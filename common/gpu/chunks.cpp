#include "common/gpu/chunks.h"

#include <meshoptimizer.h>

#include <algorithm>

namespace meshloop {
namespace {

/// Small enough that a view leaves most of what it does not show out, large enough that a call to draw one costs
/// little.
constexpr std::size_t kTrianglesPerChunk = 512;

}  // namespace

ChunkedTriangles make_chunks(const Submesh& submesh) {
  ChunkedTriangles result;
  const std::size_t count = submesh.triangles.size();
  if (count == 0) return result;
  static_assert(sizeof(Triangle) == 3 * sizeof(unsigned));
  result.triangles.resize(count);
  auto* sorted = result.triangles.front().data();
  meshopt_spatialSortTriangles(sorted, submesh.triangles.front().data(), 3 * count, submesh.positions.front().data(),
                               submesh.positions.size(), sizeof(Eigen::Vector3f));
  for (std::size_t first = 0; first < count; first += kTrianglesPerChunk) {
    const std::size_t last = std::min(count, first + kTrianglesPerChunk);
    Chunk chunk;
    chunk.first_index = static_cast<int>(3 * first);
    chunk.index_count = static_cast<int>(3 * (last - first));
    for (std::size_t i = first; i < last; ++i) {
      for (const auto vertex : result.triangles[i]) chunk.bounds.extend(submesh.positions[vertex]);
    }
    result.chunks.push_back(chunk);
  }
  return result;
}

}  // namespace meshloop
