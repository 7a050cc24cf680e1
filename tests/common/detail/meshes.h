#pragma once
// Surfaces for the tests of this room.
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "common/mesh/submesh.h"

namespace meshloop::test {

/// A rectangle of 2 x 2 m with hills of 5 cm, n cells a side.
inline Submesh hills(std::uint32_t n) {
  Submesh mesh;
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const float u = 2 * static_cast<float>(x) / static_cast<float>(n) - 1;
      const float v = 2 * static_cast<float>(y) / static_cast<float>(n) - 1;
      mesh.positions.emplace_back(u, v, 0.05f * std::sin(7 * u) * std::cos(5 * v));
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t here = y * (n + 1) + x;
      mesh.triangles.push_back({here, here + 1, here + n + 1});
      mesh.triangles.push_back({here + 1, here + n + 2, here + n + 1});
    }
  }
  return mesh;
}

/// A closed ball of radius 1 m.
inline Submesh ball(std::uint32_t rings) {
  Submesh mesh;
  const std::uint32_t around = 2 * rings;
  mesh.positions.emplace_back(0, 0, 1);
  for (std::uint32_t i = 1; i < rings; ++i) {
    const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rings);
    for (std::uint32_t k = 0; k < around; ++k) {
      const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / static_cast<float>(around);
      mesh.positions.emplace_back(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle),
                                  std::cos(polar));
    }
  }
  mesh.positions.emplace_back(0, 0, -1);
  const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  const auto at = [&](std::uint32_t ring, std::uint32_t k) { return 1 + (ring - 1) * around + k % around; };
  for (std::uint32_t k = 0; k < around; ++k) {
    mesh.triangles.push_back({0, at(1, k), at(1, k + 1)});
    mesh.triangles.push_back({last, at(rings - 1, k + 1), at(rings - 1, k)});
    for (std::uint32_t ring = 1; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)});
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring, k + 1)});
    }
  }
  return mesh;
}

/// Both in one submesh; the second moved along x.
inline Submesh beside(const Submesh& one, const Submesh& other, float along_x_m) {
  Submesh both = one;
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  for (const auto& p : other.positions) both.positions.emplace_back(p.x() + along_x_m, p.y(), p.z());
  for (const auto& [a, b, c] : other.triangles) both.triangles.push_back({a + first, b + first, c + first});
  return both;
}

inline Submesh inside_out(Submesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  return mesh;
}

}  // namespace meshloop::test
