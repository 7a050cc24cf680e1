#pragma once
// A patch lies on a coarse lattice, but for the vertices of its border that it shares with a surface beside it. Draco
// then has all of them on the coarse lattice, and by how much which vertices at the border are beside it is coded
// apart.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/codec/bit_coder.h"
#include "common/mesh/submesh.h"

namespace meshloop {

/// From a point of a coarse lattice, in steps of the finest one: from -coarsening / 2 to coarsening / 2 - 1.
using LatticeOffset = std::array<std::int8_t, 3>;

/// For each vertex whether the triangles around it leave a gap. Two gaps that are alike may hide each other.
[[nodiscard]] std::vector<bool> border_vertices(std::span<const Triangle> triangles, std::size_t vertices);

/// The coarsening (2, 4 or 8) with which this way takes the fewest bits; 1 where it takes no fewer than the lattice of
/// `coarsening_of` for all, or where a vertex that is not at the border would have an offset.
[[nodiscard]] int coarsening_inside(const Submesh& submesh);

/// Moves positions on the lattice to the coarser one, and says by how much each was off. Exact.
[[nodiscard]] std::vector<LatticeOffset> take_offsets(std::vector<Eigen::Vector3f>& positions, int coarsening);

/// For each vertex of the border whether it is beside its point, and its offset then. Vertices that are not at the
/// border must have none.
void encode_offsets(BitEncoder& out, std::span<const LatticeOffset> offsets, const std::vector<bool>& is_border,
                    int coarsening);

/// Moves the positions by what the bits say. Refuses positions that are not on the coarse lattice, and offsets of zero
/// that are said to be others, or of no vertex at all.
[[nodiscard]] Status decode_offsets(BitDecoder& in, const std::vector<bool>& is_border, int coarsening,
                                    std::span<Eigen::Vector3f> positions);

}  // namespace meshloop
