#include "common/interchange/weld.h"

#include <array>
#include <bit>
#include <cstddef>
#include <unordered_map>

namespace meshloop {
namespace {

using VertexKey = std::array<std::uint32_t, 4>;

struct VertexKeyHash {
  std::size_t operator()(const VertexKey& key) const {
    std::uint64_t hash = 0x9e3779b97f4a7c15;
    for (const auto word : key) {
      hash = (hash ^ word) * 0xff51afd7ed558ccd;
      hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
  }
};

VertexKey key_of(const Submesh& submesh, std::uint32_t index) {
  // Adding zero makes -0 and 0 one value.
  const Eigen::Vector3f p = submesh.positions[index].array() + 0.0f;
  std::uint32_t color = 0;
  if (submesh.has_colors()) {
    const Rgb8& c = submesh.colors[index];
    color = static_cast<std::uint32_t>(c.r << 16 | c.g << 8 | c.b);
  }
  return {std::bit_cast<std::uint32_t>(p.x()), std::bit_cast<std::uint32_t>(p.y()), std::bit_cast<std::uint32_t>(p.z()),
          color};
}

}  // namespace

Submesh welded(const Submesh& submesh) {
  std::unordered_map<VertexKey, std::uint32_t, VertexKeyHash> new_index;
  new_index.reserve(submesh.positions.size());
  Submesh joined;
  joined.triangles = submesh.triangles;
  for (auto& triangle : joined.triangles) {
    for (auto& index : triangle) {
      const auto next = static_cast<std::uint32_t>(joined.positions.size());
      const auto [it, is_new] = new_index.emplace(key_of(submesh, index), next);
      if (is_new) {
        joined.positions.push_back(submesh.positions[index]);
        if (submesh.has_colors()) joined.colors.push_back(submesh.colors[index]);
      }
      index = it->second;
    }
  }
  return joined;
}

}  // namespace meshloop
