#pragma once
// Submesh <-> Draco bytes (Edgebreaker), the colours after them, the texture's JPEG beside them. The only user of
// Draco.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/submesh.h"

namespace meshloop {

struct EncodeOptions {
  /// 0 smallest, 10 fastest.
  int speed = 2;
};

/// Positions must lie on the scene's lattice (see mesh/lattice.h) and span less than 2048 m. They, the colours and the
/// triangles (with their winding) come back exactly, in another order; vertices that no triangle uses do not. Vertices
/// may come back twice where triangles meet in more than one fan. A texture comes back byte for byte. Thread-safe: no
/// state is shared.
[[nodiscard]] Result<std::vector<std::byte>> encode(const Submesh& submesh, const EncodeOptions& options = {});

struct DecodeLimits {
  std::size_t max_bytes = 4u << 20;
  /// Those that Edgebreaker's splits make while it decodes are counted too: at most 7 in 100 on a camera's grids, 45
  /// where every seventh triangle is missing.
  std::size_t max_vertices = 2'000'000;
  std::size_t max_triangles = 4'000'000;
};

/// Refuses what is not one mesh within the limits, before memory is spent on it. What comes back is valid and lies on
/// the lattice, and its texture can be decoded. Check the payload's hash before: this function survives hostile bytes
/// as far as tests have found, but Draco makes no promise. Thread-safe.
[[nodiscard]] Result<Submesh> decode(std::span<const std::byte> bytes, const DecodeLimits& limits = {});

}  // namespace meshloop
