#pragma once
// Submesh <-> Draco bytes (Edgebreaker). The only user of Draco.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/submesh.h"

namespace meshloop {

struct EncodeOptions {
  /// 0 smallest, 10 fastest.
  int speed = 5;
};

/// Positions must lie on the scene's lattice (see mesh/lattice.h). They, the colours and the triangles come back exactly,
/// in another order.
[[nodiscard]] Result<std::vector<std::byte>> encode(const Submesh& submesh, const EncodeOptions& options = {});

struct DecodeLimits {
  std::size_t max_bytes = 4u << 20;
  std::size_t max_vertices = 2'000'000;
  std::size_t max_triangles = 4'000'000;
};

/// Refuses what is not one mesh within the limits, before memory is spent on it. What comes back is valid.
[[nodiscard]] Result<Submesh> decode(std::span<const std::byte> bytes, const DecodeLimits& limits = {});

}  // namespace meshloop
