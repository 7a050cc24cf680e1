#include "common/codec/mesh_tail.h"

#include <bit>

#include "common/codec/color_coder.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

enum Colors : unsigned { kNoColors = 0, kAllColors = 1, kCoarseColors = 2 };

Status read_coded(std::span<const std::byte> bytes, unsigned colors, int coarsening, Submesh& mesh) {
  // No writer leaves a zero at the end.
  if (!bytes.empty() && bytes.back() == std::byte{0}) return fail("bytes follow after the mesh");
  BitDecoder in{bytes};
  if (colors != kNoColors)
    mesh.colors = decode_colors(in, mesh.positions.size(), colors == kCoarseColors ? kCoarseColorStep : 1);
  if (coarsening > 1) {
    const auto is_border = border_vertices(mesh.triangles, mesh.positions.size());
    if (auto ok = decode_offsets(in, is_border, coarsening, mesh.positions); !ok) return ok;
  }
  return in.is_at_end() ? Status{} : fail("bytes follow after the mesh");
}

}  // namespace

std::vector<std::byte> write_mesh_tail(const MeshTail& tail, const std::vector<bool>& is_border) {
  const int step = color_step(tail.colors);
  const unsigned colors = tail.colors.empty() ? kNoColors : step > 1 ? kCoarseColors : kAllColors;
  const auto power = static_cast<unsigned>(std::countr_zero(static_cast<unsigned>(tail.coarsening)));
  std::vector<std::byte> bytes{static_cast<std::byte>(colors | power << 2)};
  if (bytes[0] == std::byte{0}) return bytes;
  BitEncoder out;
  encode_colors(out, tail.colors, step);
  if (tail.coarsening > 1) encode_offsets(out, tail.offsets, is_border, tail.coarsening);
  const auto coded = out.finish();
  bytes.insert(bytes.end(), coded.begin(), coded.end());
  return bytes;
}

Status read_mesh_tail(std::span<const std::byte> bytes, Submesh& mesh) {
  if (bytes.empty()) return fail("the payload ends after Draco's part");
  const auto what = std::to_integer<unsigned>(bytes.front());
  const unsigned colors = what & 3U;
  const unsigned power = what >> 2;
  if (colors > kCoarseColors || power > 3) return fail("an unknown part follows after the mesh");
  bytes = bytes.subspan(1);
  if (what == 0) return bytes.empty() ? Status{} : fail("bytes follow after the mesh");
  return read_coded(bytes, colors, 1 << power, mesh);
}

}  // namespace meshloop
