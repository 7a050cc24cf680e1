#include "common/interchange/split.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>

namespace meshloop {
namespace {

using TriangleIds = std::span<std::uint32_t>;

Eigen::Vector3f centre_of(const Submesh& submesh, std::uint32_t id) {
  const auto& [a, b, c] = submesh.triangles[id];
  return (submesh.positions[a] + submesh.positions[b] + submesh.positions[c]) / 3;
}

/// Orders the ids so that the first half lies below the median of the longest axis; returns where the second starts.
std::size_t halve(const Submesh& submesh, TriangleIds ids) {
  Eigen::AlignedBox3f box;
  for (const auto id : ids) box.extend(centre_of(submesh, id));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = ids.begin() + static_cast<std::ptrdiff_t>(ids.size() / 2);
  std::nth_element(ids.begin(), middle, ids.end(), [&](std::uint32_t a, std::uint32_t b) {
    const float pa = centre_of(submesh, a)[axis], pb = centre_of(submesh, b)[axis];
    return pa != pb ? pa < pb : a < b;
  });
  return ids.size() / 2;
}

/// Pieces of one submesh. Keeps the order of its triangles and vertices; costs as much as the piece is large.
class Pieces {
 public:
  explicit Pieces(const Submesh& submesh) : submesh_{submesh}, new_index_(submesh.positions.size()) {}

  Submesh make(TriangleIds ids) {
    std::sort(ids.begin(), ids.end());
    std::vector<std::uint32_t> used;
    used.reserve(3 * ids.size());
    for (const auto id : ids) used.insert(used.end(), submesh_.triangles[id].begin(), submesh_.triangles[id].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    Submesh piece;
    piece.texture = submesh_.texture;
    piece.positions.reserve(used.size());
    for (const auto index : used) {
      new_index_[index] = static_cast<std::uint32_t>(piece.positions.size());
      piece.positions.push_back(submesh_.positions[index]);
      if (submesh_.has_colors()) piece.colors.push_back(submesh_.colors[index]);
    }
    piece.triangles.reserve(ids.size());
    for (const auto id : ids) {
      const auto& [a, b, c] = submesh_.triangles[id];
      piece.triangles.push_back({new_index_[a], new_index_[b], new_index_[c]});
    }
    return piece;
  }

 private:
  const Submesh& submesh_;
  std::vector<std::uint32_t> new_index_;
};

}  // namespace

std::vector<Submesh> split_in_space(const Submesh& submesh, std::size_t max_triangles) {
  const std::size_t limit = std::max<std::size_t>(max_triangles, 1);
  if (submesh.triangles.size() <= limit) return {submesh};
  std::vector<std::uint32_t> ids(submesh.triangles.size());
  std::iota(ids.begin(), ids.end(), 0u);
  std::vector<Submesh> pieces;
  Pieces maker{submesh};
  std::vector<TriangleIds> open{ids};
  while (!open.empty()) {
    const TriangleIds group = open.back();
    open.pop_back();
    if (group.size() <= limit) {
      pieces.push_back(maker.make(group));
      continue;
    }
    const auto second = halve(submesh, group);
    open.push_back(group.subspan(second));
    open.push_back(group.first(second));
  }
  return pieces;
}

}  // namespace meshloop
