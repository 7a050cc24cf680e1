#pragma once
#include <cstddef>
#include <vector>

#include "server/adjust/color_lookup.h"
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// One node holds at most this many triangles: with the largest texture (kMostTextureBytes) they then fit into the 1
/// MiB that a message may have.
inline constexpr std::size_t kMaxPatchTriangles = 60'000;

/// Says what keeps a snapshot from being used: something missing, images of different sizes, a pose that is lost.
[[nodiscard]] Status validate(const Snapshot& snapshot);

/// `insertion_patch` with the colours prepared. The snapshot must be valid.
[[nodiscard]] Submesh make_patch(const Snapshot& snapshot, RegionId region, const AdjustOptions& options,
                                 const ColorLookup& colors);

/// Cuts a submesh between triangles into pieces near each other in space, of at most `max_triangles` each. Vertices
/// along a cut are in both pieces, with the same bits.
[[nodiscard]] std::vector<Submesh> split(Submesh submesh, std::size_t max_triangles);

}  // namespace meshloop::adjust
