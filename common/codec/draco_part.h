#pragma once
// The part of a payload that Draco has written: triangles and positions.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/submesh.h"

namespace meshloop {

/// Vertices as Draco's decoder numbers them, which is the order that what follows in a payload has: along its
/// triangles.
struct DracoPart {
  Submesh mesh;
  /// Which of the positions that were written each vertex has.
  std::vector<std::uint32_t> written;
  /// Of the payload.
  std::size_t bytes = 0;
};

/// Check the counts at its start before (`draco_header.h`). Stops where another attribute than one of positions comes.
/// Throws what Draco throws.
[[nodiscard]] Result<DracoPart> read_draco_part(std::span<const std::byte> payload);

}  // namespace meshloop
