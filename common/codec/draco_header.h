#pragma once
// The first bytes of a Draco stream (bitstream 2.2), read without Draco: what a payload claims, before memory is spent
// on the claim. Layout: https://google.github.io/draco/spec, sections 4.2 (header) and 5.2 (Edgebreaker connectivity).
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/base/result.h"

namespace meshloop {

/// The counts an Edgebreaker mesh starts with.
struct DracoCounts {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  std::uint64_t symbols = 0;
  std::uint64_t split_symbols = 0;

  /// The decoder makes a vertex for each split too; those that were split are joined again at its end.
  [[nodiscard]] std::uint64_t most_vertices() const { return vertices + split_symbols; }
};

/// Refuses what is not one Edgebreaker mesh of bitstream 2.2 without metadata and without seams (attributes that are
/// connected otherwise than the positions), and counts that contradict each other.
[[nodiscard]] Result<DracoCounts> read_draco_counts(std::span<const std::byte> bytes);

/// A payload may claim at most so many triangles per byte: bounds what a short hostile payload can make the decoder
/// allocate. Encoding falls back to the plain Edgebreaker (at least a bit a triangle) where a mesh is more regular.
inline constexpr std::size_t kMaxTrianglesPerByte = 64;

}  // namespace meshloop
