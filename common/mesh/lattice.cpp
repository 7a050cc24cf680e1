#include "common/mesh/lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "common/base/target_clones.h"

namespace meshloop {
namespace {

// Where floats are a whole number apart they have no fraction left; adding that much and taking it away rounds what is
// smaller. In place of std::round, which is a call where the processor's instruction for it is not taken for granted.
float nearest_whole(float value) {
  constexpr float kNoFraction = 8'388'608;  // 2^23
  const float size = std::abs(value);
  const float added = size < kNoFraction ? kNoFraction : 0.0f;
  return std::copysign((size + added) - added, value);
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
MESHLOOP_TARGET_CLONES
void snap(float* values, std::size_t count, float spacing_m) {
  const float per_spacing = 1 / spacing_m;
  for (std::size_t i = 0; i < count; ++i) values[i] = snapped(values[i], spacing_m, per_spacing);
}

void snap(std::vector<Eigen::Vector3f>& positions, float spacing_m) {
  if (!positions.empty()) snap(positions.front().data(), 3 * positions.size(), spacing_m);
}

bool same_bits(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return a == b && std::signbit(a.x()) == std::signbit(b.x()) && std::signbit(a.y()) == std::signbit(b.y()) &&
         std::signbit(a.z()) == std::signbit(b.z());
}

bool is_on_lattice_of(const Submesh& submesh, int coarsening) {
  return std::all_of(submesh.positions.begin(), submesh.positions.end(),
                     [=](const Eigen::Vector3f& p) { return is_on_lattice(p, coarsening); });
}

struct Faults {
  std::vector<std::uint32_t> flat_triangles;
  bool has_unused_vertices = false;
};

Faults faults_of(const Submesh& submesh) {
  Faults faults;
  std::vector<std::uint8_t> used(submesh.positions.size(), 0);
  std::uint8_t* is_used = used.data();
  for (std::uint32_t t = 0; t < submesh.triangles.size(); ++t) {
    const Triangle triangle = submesh.triangles[t];
    if (!has_area(submesh, triangle)) faults.flat_triangles.push_back(t);
    for (const auto index : triangle) is_used[index] = 1;
  }
  faults.has_unused_vertices = std::find(used.begin(), used.end(), std::uint8_t{0}) != used.end();
  return faults;
}

constexpr int kFlips = 4;

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Flat triangles whose corners lie in different places, by their longest edge as the triangle beside has it.
std::map<Edge, std::uint32_t> by_longest_edge(const Submesh& submesh, const std::vector<std::uint32_t>& flat) {
  const auto& p = submesh.positions;
  std::map<Edge, std::uint32_t> found;
  for (const auto t : flat) {
    const auto& [a, b, c] = submesh.triangles[t];
    if (p[a] == p[b] || p[b] == p[c] || p[c] == p[a]) continue;
    const std::array<std::pair<float, Edge>, 3> edges{{{(p[b] - p[a]).squaredNorm(), {b, a}},
                                                       {(p[c] - p[b]).squaredNorm(), {c, b}},
                                                       {(p[a] - p[c]).squaredNorm(), {a, c}}}};
    found[std::max_element(edges.begin(), edges.end())->second] = t;
  }
  return found;
}

// A flat triangle whose corners lie in different places has one of them on the edge between the others. Without it that
// edge would meet two shorter ones: so it is flipped with the triangle at that edge, and both have area. Triangles with
// two corners in one place leave nothing open. Returns which are flat now.
std::vector<std::uint32_t> flip_flat_triangles(Submesh& submesh, const std::vector<std::uint32_t>& flat) {
  const auto flat_at = by_longest_edge(submesh, flat);
  if (flat_at.empty()) return flat;
  std::vector<std::uint8_t> begins_edge(submesh.positions.size(), 0);
  for (const auto& [edge, t] : flat_at) begins_edge[edge.first] = 1;
  std::vector<std::uint32_t> looked_at = flat;
  std::set<std::uint32_t> changed;
  for (std::uint32_t u = 0; u < submesh.triangles.size(); ++u) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (begins_edge[submesh.triangles[u][k]] == 0) continue;
      const Edge edge{submesh.triangles[u][k], submesh.triangles[u][(k + 1) % 3]};
      const auto found = flat_at.find(edge);
      // What has changed already no longer has the edges that it was found by; the next round looks again.
      if (found == flat_at.end() || found->second == u || changed.contains(u) || changed.contains(found->second))
        continue;
      const auto opposite = submesh.triangles[u][(k + 2) % 3];
      auto& other = submesh.triangles[found->second];
      const auto middle = *std::find_if(other.begin(), other.end(),
                                        [&](std::uint32_t i) { return i != edge.first && i != edge.second; });
      other = {edge.first, middle, opposite};
      submesh.triangles[u] = {middle, edge.second, opposite};
      looked_at.push_back(u);
      changed.insert({u, found->second});
      break;
    }
  }
  std::sort(looked_at.begin(), looked_at.end());
  looked_at.erase(std::unique(looked_at.begin(), looked_at.end()), looked_at.end());
  std::erase_if(looked_at, [&](std::uint32_t t) { return has_area(submesh, submesh.triangles[t]); });
  return looked_at;
}

}  // namespace

Eigen::Vector3f on_lattice(const Eigen::Vector3f& p) {
  return snapped(p, kLatticeSpacing_m);
}

bool is_on_lattice(const Eigen::Vector3f& p, int coarsening) {
  return same_bits(snapped(p, kLatticeSpacing_m * static_cast<float>(coarsening)), p);
}

bool is_on_lattice(const Submesh& submesh) {
  return is_on_lattice_of(submesh, 1);
}

int coarsening_of(const Submesh& submesh) {
  int coarsening = 1;
  while (coarsening < kMaxCoarsening && is_on_lattice_of(submesh, 2 * coarsening)) coarsening *= 2;
  return coarsening;
}

Submesh snap_to_lattice(Submesh submesh, int coarsening, std::span<const std::uint32_t> finest) {
  std::vector<Eigen::Vector3f> exact;
  for (const auto i : finest) exact.push_back(on_lattice(submesh.positions[i]));
  snap(submesh.positions, kLatticeSpacing_m * static_cast<float>(coarsening));
  for (std::size_t k = 0; k < finest.size(); ++k) submesh.positions[finest[k]] = exact[k];
  auto [flat, has_unused_vertices] = faults_of(submesh);
  if (flat.empty() && !has_unused_vertices) return submesh;
  // What a flat triangle is flipped with may itself have been flat.
  for (int i = 0; i < kFlips; ++i) {
    auto still_flat = flip_flat_triangles(submesh, flat);
    if (still_flat == flat) break;
    flat = std::move(still_flat);
  }
  std::vector<bool> keep(submesh.triangles.size(), true);
  for (const auto t : flat) keep[t] = false;
  return keep_triangles(std::move(submesh), keep);
}

}  // namespace meshloop
