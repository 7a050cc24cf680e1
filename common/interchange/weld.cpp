#include "common/interchange/weld.h"

#include <bit>
#include <cstddef>
#include <limits>

namespace meshloop {
namespace {

constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();

/// Finds the joined vertex that equals a given one: open addressing in a table of indices, at most half full.
class VertexTable {
 public:
  explicit VertexTable(std::size_t most_vertices) : slots_(std::bit_ceil(2 * most_vertices + 1), kNone) {}

  /// The index in `joined` of a vertex with this position and colour, appended when there is none.
  std::uint32_t find_or_add(const Eigen::Vector3f& position, const Rgb8* color, Submesh& joined) {
    for (std::size_t at = hash(position, color) & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
      const std::uint32_t index = slots_[at];
      if (index != kNone) {
        if (joined.positions[index] == position && (color == nullptr || joined.colors[index] == *color)) return index;
        continue;
      }
      slots_[at] = static_cast<std::uint32_t>(joined.positions.size());
      joined.positions.push_back(position);
      if (color != nullptr) joined.colors.push_back(*color);
      return slots_[at];
    }
  }

 private:
  static std::size_t hash(const Eigen::Vector3f& position, const Rgb8* color) {
    std::uint64_t hash = 0x9e3779b97f4a7c15;
    const auto mix = [&hash](std::uint32_t word) {
      hash = (hash ^ word) * 0xff51afd7ed558ccd;
      hash ^= hash >> 32;
    };
    // Adding zero makes -0 and 0, which are equal, one value.
    for (const float value : position) mix(std::bit_cast<std::uint32_t>(value + 0.0f));
    if (color != nullptr) mix(static_cast<std::uint32_t>(color->r << 16 | color->g << 8 | color->b));
    return static_cast<std::size_t>(hash);
  }

  std::vector<std::uint32_t> slots_;
};

}  // namespace

Submesh welded(Submesh submesh) {
  Submesh joined;
  joined.positions.reserve(submesh.positions.size());
  joined.colors.reserve(submesh.colors.size());
  VertexTable table{submesh.positions.size()};
  std::vector<std::uint32_t> new_index(submesh.positions.size(), kNone);
  for (auto& triangle : submesh.triangles) {
    for (auto& index : triangle) {
      std::uint32_t& known = new_index[index];
      if (known == kNone) {
        const Rgb8* color = submesh.has_colors() ? &submesh.colors[index] : nullptr;
        known = table.find_or_add(submesh.positions[index], color, joined);
      }
      index = known;
    }
  }
  joined.triangles = std::move(submesh.triangles);
  joined.texture = std::move(submesh.texture);
  joined.positions.shrink_to_fit();
  joined.colors.shrink_to_fit();
  return joined;
}

}  // namespace meshloop
