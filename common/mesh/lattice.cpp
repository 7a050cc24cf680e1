#include "common/mesh/lattice.h"

#include <algorithm>
#include <cmath>

namespace meshloop {
namespace {

// Where floats are a whole number apart they have no fraction left; adding that much and taking it away rounds what is
// smaller. In place of std::round, which is a call where the processor's instruction for it is not taken for granted.
float nearest_whole(float value) {
  constexpr float kNoFraction = 8'388'608;  // 2^23
  const float size = std::abs(value);
  return size < kNoFraction ? std::copysign((size + kNoFraction) - kNoFraction, value) : value;
}

// The spacing is a power of two, so its inverse is exact. Adding zero makes -0 to 0: the two compare equal, but would
// give one shape two hashes.
float snapped(float value, float spacing_m, float per_spacing) {
  return nearest_whole(value * per_spacing) * spacing_m + 0.0f;
}

Eigen::Vector3f snapped(const Eigen::Vector3f& p, float spacing_m) {
  return p.unaryExpr([&](float value) { return snapped(value, spacing_m, 1 / spacing_m); });
}

// As one row of numbers, several of which are rounded at once.
void snap(std::vector<Eigen::Vector3f>& positions, float spacing_m) {
  const float per_spacing = 1 / spacing_m;
  float* values = positions.empty() ? nullptr : positions.front().data();
  for (std::size_t i = 0; i < 3 * positions.size(); ++i) values[i] = snapped(values[i], spacing_m, per_spacing);
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

bool every_vertex_is_used(const Submesh& submesh) {
  std::vector<std::uint8_t> used(submesh.positions.size(), 0);
  for (const auto& triangle : submesh.triangles) {
    for (const auto index : triangle) used[index] = 1;
  }
  return std::find(used.begin(), used.end(), std::uint8_t{0}) == used.end();
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

Submesh snap_to_lattice(Submesh submesh, int coarsening) {
  const float spacing_m = kLatticeSpacing_m * static_cast<float>(coarsening);
  snap(submesh.positions, spacing_m);
  const auto flat = [&](const Triangle& triangle) { return !has_area(submesh, triangle); };
  const auto first = std::find_if(submesh.triangles.begin(), submesh.triangles.end(), flat);
  if (first == submesh.triangles.end() && every_vertex_is_used(submesh)) return submesh;
  std::vector<bool> keep(submesh.triangles.size(), true);
  for (auto it = first; it != submesh.triangles.end(); ++it)
    keep[static_cast<std::size_t>(it - submesh.triangles.begin())] = !flat(*it);
  return keep_triangles(submesh, keep);
}

}  // namespace meshloop
