#include "common/codec/draco_header.h"

#include <array>
#include <optional>

namespace meshloop {
namespace {

constexpr std::array kMagic{'D', 'R', 'A', 'C', 'O'};
constexpr std::uint8_t kTriangularMesh = 1;
constexpr std::uint8_t kEdgebreaker = 1;
constexpr unsigned kMetadataFlag = 0x8000;

class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_{bytes} {}

  std::optional<std::uint8_t> byte() {
    if (rest_.empty()) return std::nullopt;
    const auto value = std::to_integer<std::uint8_t>(rest_.front());
    rest_ = rest_.subspan(1);
    return value;
  }

  /// Seven bits a byte, lowest first; all counts of the format have 32 bits.
  std::optional<std::uint64_t> varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const auto next = byte();
      if (!next) return std::nullopt;
      value |= static_cast<std::uint64_t>(*next & 0x7f) << shift;
      if ((*next & 0x80) == 0) return value;
    }
    return std::nullopt;
  }

 private:
  std::span<const std::byte> rest_;
};

Status check_header(ByteReader& in) {
  for (const char letter : kMagic) {
    if (in.byte() != static_cast<std::uint8_t>(letter)) return fail("the payload is not Draco");
  }
  const auto major = in.byte();
  const auto minor = in.byte();
  const auto type = in.byte();
  const auto method = in.byte();
  const auto flags_low = in.byte();
  const auto flags_high = in.byte();
  if (!flags_high) return fail("the Draco payload ends within its header");
  if (major != 2 || minor != 2) return fail("the Draco payload has a bitstream other than 2.2");
  if (type != kTriangularMesh || method != kEdgebreaker) return fail("the Draco payload is not an Edgebreaker mesh");
  const unsigned flags = *flags_low | static_cast<unsigned>(*flags_high) << 8;
  if ((flags & kMetadataFlag) != 0) return fail("the Draco payload carries metadata, which no station writes");
  return {};
}

}  // namespace

Result<DracoCounts> read_draco_counts(std::span<const std::byte> bytes) {
  ByteReader in{bytes};
  if (auto ok = check_header(in); !ok) return fail(ok.error());
  const auto traversal = in.byte();
  const auto vertices = in.varint();
  const auto faces = in.varint();
  const auto connectivities = in.byte();
  const auto symbols = in.varint();
  const auto splits = in.varint();
  if (!traversal || !vertices || !faces || !connectivities || !symbols || !splits) {
    return fail("the Draco payload ends within its counts");
  }
  // Traversal 1 is deprecated; no encoder of bitstream 2.2 writes it.
  if (*traversal != 0 && *traversal != 2) return fail("the Draco payload has an unknown traversal");
  // With seams the decoder would make up to three vertices of each face.
  if (*connectivities != 0) return fail("the Draco payload has attributes with seams, which no station writes");
  if (*faces == 0 || *vertices < 3 || *vertices > 3 * *faces || *symbols > *faces || *splits > *symbols) {
    return fail("the counts in the Draco payload contradict each other");
  }
  return DracoCounts{*vertices, *faces, *symbols, *splits};
}

}  // namespace meshloop
