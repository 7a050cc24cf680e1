#pragma once
// What a payload has of a mesh after Draco's part, which holds triangles and positions: a byte that says what there is
// (bits 0 and 1: no colours, colours, colours in steps of kCoarseColorStep; bits 2 and 3: the power of two of the
// lattice's coarsening inside of the border; others zero), and where it is not zero colours, then offsets of the
// border, in one run of the range coder (`bit_coder.h`) to the payload's end.
#include <cstddef>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/codec/border_offsets.h"
#include "common/mesh/submesh.h"

namespace meshloop {

/// Vertices in the order of `DracoPart`.
struct MeshTail {
  std::vector<Rgb8> colors;
  /// 1: no vertex has an offset.
  int coarsening = 1;
  std::vector<LatticeOffset> offsets;
};

/// Only vertices at the border may have offsets.
[[nodiscard]] std::vector<std::byte> write_mesh_tail(const MeshTail& tail, const std::vector<bool>& is_border);

/// Gives the mesh its colours, and moves the vertices at its border. Refuses a zero as the last byte, and bytes that
/// the decoder does not come to; it looks four bytes ahead, and further where the writer left out zeros at the end, and
/// so many others are taken. Bytes that were cut are read as zeros: a payload's hash finds that.
[[nodiscard]] Status read_mesh_tail(std::span<const std::byte> bytes, Submesh& mesh);

}  // namespace meshloop
