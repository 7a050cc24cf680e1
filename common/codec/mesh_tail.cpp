#include "common/codec/mesh_tail.h"

#include <bit>
#include <optional>

#include "common/codec/color_coder.h"
#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

enum Colors : unsigned { kNoColors = 0, kAllColors = 1, kCoarseColors = 2 };

void append_length(std::vector<std::byte>& bytes, std::size_t length) {
  for (; length > 127; length >>= 7) bytes.push_back(static_cast<std::byte>(length | 0x80));
  bytes.push_back(static_cast<std::byte>(length));
}

std::optional<std::size_t> take_length(std::span<const std::byte>& bytes) {
  std::size_t length = 0;
  for (unsigned shift = 0; shift < 35 && !bytes.empty(); shift += 7) {
    const auto next = std::to_integer<std::size_t>(bytes.front());
    bytes = bytes.subspan(1);
    length |= (next & 0x7f) << shift;
    if ((next & 0x80) == 0) return length;
  }
  return std::nullopt;
}

Status read_coded(std::span<const std::byte> bytes, unsigned colors, int coarsening, Submesh& mesh) {
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
  append_length(bytes, coded.size());
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
  const auto length = take_length(bytes);
  if (!length || *length > bytes.size()) return fail("the payload ends early");
  if (*length < bytes.size()) return fail("bytes follow after the mesh");
  return read_coded(bytes, colors, 1 << power, mesh);
}

}  // namespace meshloop
