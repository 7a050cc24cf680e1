#pragma once
// The sending side as a device's tests need it: geometry to samples, without the station's own code.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/codec/mesh_codec.h"
#include "common/mesh/lattice.h"
#include "common/transport/scene_link.h"

namespace meshloop::test {

/// A wavy coloured grid of 2 n^2 triangles on the lattice with 3 mm of noise, as a depth patch would be; `shape` makes
/// each one different.
inline Submesh patch(std::uint32_t n, unsigned shape) {
  Submesh mesh;
  unsigned seed = shape;
  const auto noise = [&](unsigned range) {
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 16) % range;
  };
  for (std::uint32_t y = 0; y <= n; ++y) {
    for (std::uint32_t x = 0; x <= n; ++x) {
      const auto fx = static_cast<float>(x);
      const auto fy = static_cast<float>(y);
      const float wave = 400.0f * std::sin(0.05f * fx + static_cast<float>(shape)) * std::cos(0.07f * fy);
      // Zero has one sign on the lattice.
      const float height = std::round(wave) + static_cast<float>(noise(12)) + 0.0f;
      const auto jitter_x = static_cast<float>(noise(6));
      const auto jitter_y = static_cast<float>(noise(6));
      mesh.positions.emplace_back(Eigen::Vector3f{12.0f * fx + jitter_x, 12.0f * fy + jitter_y, height} *
                                  kLatticeSpacing_m);
      const auto grey = static_cast<std::uint8_t>(100 + x % 100 + noise(8));
      mesh.colors.push_back({grey, static_cast<std::uint8_t>(grey + noise(3)), 90});
    }
  }
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const std::uint32_t a = y * (n + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return mesh;
}

template <class T>
T must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

inline NodePayload payload_of(NodeId id, const Submesh& mesh, std::uint64_t epoch, Revision revision) {
  NodePayload payload{id, epoch, revision, {}, must(encode(mesh))};
  payload.hash = hash_of(payload.bytes);
  return payload;
}

inline Manifest manifest_of(std::uint64_t epoch, Revision revision, const std::vector<NodePayload>& nodes) {
  Manifest manifest{epoch, revision, wall_clock_ns(), {}};
  for (const auto& node : nodes) {
    manifest.nodes.push_back({node.id, fmt::format("node {}", node.id), Pose::Identity(), node.hash});
  }
  return manifest;
}

/// The triangles as points, so that meshes compare whatever the order of their vertices.
inline std::multiset<std::vector<float>> shape_of(const Submesh& mesh) {
  std::multiset<std::vector<float>> triangles;
  for (const auto& triangle : mesh.triangles) {
    std::size_t first = 0;
    const auto less = [&](std::size_t a, std::size_t b) {
      const auto& p = mesh.positions[triangle[a]];
      const auto& q = mesh.positions[triangle[b]];
      return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
    };
    for (std::size_t corner : {1u, 2u}) first = less(corner, first) ? corner : first;
    std::vector<float> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& p = mesh.positions[triangle[(first + i) % 3]];
      corners.insert(corners.end(), p.data(), p.data() + 3);
    }
    triangles.insert(std::move(corners));
  }
  return triangles;
}

inline LinkOptions options_of(const std::string& scene) {
  LinkOptions options;
  options.scene = scene;
  options.domain = 1 + static_cast<unsigned>(getpid()) % 100;
  return options;
}

}  // namespace meshloop::test
