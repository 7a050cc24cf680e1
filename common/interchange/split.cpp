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

Submesh piece_of(const Submesh& submesh, TriangleIds ids) {
  std::vector<bool> keep(submesh.triangles.size());
  for (const auto id : ids) keep[id] = true;
  return keep_triangles(submesh, keep);
}

}  // namespace

std::vector<Submesh> split_in_space(const Submesh& submesh, std::size_t max_triangles) {
  const std::size_t limit = std::max<std::size_t>(max_triangles, 1);
  if (submesh.triangles.size() <= limit) return {submesh};
  std::vector<std::uint32_t> ids(submesh.triangles.size());
  std::iota(ids.begin(), ids.end(), 0u);
  std::vector<Submesh> pieces;
  std::vector<TriangleIds> open{ids};
  while (!open.empty()) {
    const TriangleIds group = open.back();
    open.pop_back();
    if (group.size() <= limit) {
      pieces.push_back(piece_of(submesh, group));
      continue;
    }
    const auto second = halve(submesh, group);
    open.push_back(group.subspan(second));
    open.push_back(group.first(second));
  }
  return pieces;
}

}  // namespace meshloop
