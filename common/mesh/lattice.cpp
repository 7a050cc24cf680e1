#include "common/mesh/lattice.h"

#include <algorithm>
#include <cmath>

namespace meshloop {
namespace {

Eigen::Vector3f snapped(const Eigen::Vector3f& p) {
  return (p / kLatticeSpacing_m).array().round().matrix() * kLatticeSpacing_m;
}

}  // namespace

bool is_on_lattice(const Submesh& submesh) {
  return std::all_of(submesh.positions.begin(), submesh.positions.end(),
                     [](const Eigen::Vector3f& p) { return snapped(p) == p; });
}

Submesh snap_to_lattice(const Submesh& submesh) {
  Submesh moved = submesh;
  for (auto& p : moved.positions) p = snapped(p);
  std::vector<bool> has_area(moved.triangles.size());
  for (std::size_t t = 0; t < moved.triangles.size(); ++t) {
    const auto& [a, b, c] = moved.triangles[t];
    const Eigen::Vector3f& p = moved.positions[a];
    has_area[t] = !(moved.positions[b] - p).cross(moved.positions[c] - p).isZero(0);
  }
  return keep_triangles(moved, has_area);
}

}  // namespace meshloop
