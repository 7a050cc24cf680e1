#include "common/detail/local_mesh.h"

#include <algorithm>

namespace meshloop {

LocalMesh make_local(const std::vector<Eigen::Vector3f>& positions, std::span<const Triangle> triangles) {
  LocalMesh local;
  local.vertices.reserve(3 * triangles.size());
  for (const auto& triangle : triangles) local.vertices.insert(local.vertices.end(), triangle.begin(), triangle.end());
  std::sort(local.vertices.begin(), local.vertices.end());
  local.vertices.erase(std::unique(local.vertices.begin(), local.vertices.end()), local.vertices.end());
  for (const auto vertex : local.vertices) local.positions.push_back(positions[vertex]);
  const auto number = [&](std::uint32_t vertex) {
    const auto place = std::lower_bound(local.vertices.begin(), local.vertices.end(), vertex);
    return static_cast<std::uint32_t>(place - local.vertices.begin());
  };
  for (const auto& [a, b, c] : triangles) local.triangles.push_back({number(a), number(b), number(c)});
  return local;
}

}  // namespace meshloop
