#include "common/detail/local_mesh.h"

namespace meshloop {
namespace {

constexpr std::uint32_t kUnnumbered = ~0U;

}  // namespace

PartCutter::PartCutter(const std::vector<Eigen::Vector3f>& positions)
    : positions_{positions}, number_of_(positions.size(), kUnnumbered) {}

LocalMesh PartCutter::take(std::span<const Triangle> triangles) {
  LocalMesh local;
  local.triangles.reserve(triangles.size());
  const auto number = [&](std::uint32_t vertex) {
    auto& known = number_of_[vertex];
    if (known == kUnnumbered) {
      known = static_cast<std::uint32_t>(local.vertices.size());
      local.vertices.push_back(vertex);
      local.positions.push_back(positions_[vertex]);
    }
    return known;
  };
  for (const auto& [a, b, c] : triangles) {
    const std::uint32_t first = number(a);
    const std::uint32_t second = number(b);
    local.triangles.push_back({first, second, number(c)});
  }
  for (const auto vertex : local.vertices) number_of_[vertex] = kUnnumbered;
  return local;
}

}  // namespace meshloop
