#include "common/mesh/lattice.h"

#include <algorithm>
#include <cmath>

namespace meshloop {
namespace {

// Adding zero makes -0 to 0: the two compare equal, but would give one shape two hashes.
Eigen::Vector3f snapped(const Eigen::Vector3f& p, float spacing_m) {
  return ((p / spacing_m).array().round() * spacing_m + 0.0f).matrix();
}

bool same_bits(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return a == b && std::signbit(a.x()) == std::signbit(b.x()) && std::signbit(a.y()) == std::signbit(b.y()) &&
         std::signbit(a.z()) == std::signbit(b.z());
}

bool is_on_lattice_of(const Submesh& submesh, int coarsening) {
  const float spacing_m = kLatticeSpacing_m * static_cast<float>(coarsening);
  return std::all_of(submesh.positions.begin(), submesh.positions.end(),
                     [=](const Eigen::Vector3f& p) { return same_bits(snapped(p, spacing_m), p); });
}

}  // namespace

Eigen::Vector3f on_lattice(const Eigen::Vector3f& p) {
  return snapped(p, kLatticeSpacing_m);
}

bool is_on_lattice(const Submesh& submesh) {
  return is_on_lattice_of(submesh, 1);
}

int coarsening_of(const Submesh& submesh) {
  int coarsening = 1;
  while (coarsening < kMaxCoarsening && is_on_lattice_of(submesh, 2 * coarsening)) coarsening *= 2;
  return coarsening;
}

Submesh snap_to_lattice(const Submesh& submesh, int coarsening) {
  Submesh moved = submesh;
  const float spacing_m = kLatticeSpacing_m * static_cast<float>(coarsening);
  for (auto& p : moved.positions) p = snapped(p, spacing_m);
  std::vector<bool> keep(moved.triangles.size());
  std::transform(moved.triangles.begin(), moved.triangles.end(), keep.begin(),
                 [&](const Triangle& triangle) { return has_area(moved, triangle); });
  return keep_triangles(moved, keep);
}

}  // namespace meshloop
