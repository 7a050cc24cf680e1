#include "common/codec/border_offsets.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/mesh/lattice.h"

namespace meshloop {
namespace {

constexpr LatticeOffset kNone{};

/// Vertices that are not on the coarse lattice, and whether all of them are at the border.
struct OffLattice {
  std::size_t vertices = 0;
  bool only_border = true;
};

OffLattice off_lattice(const std::vector<LatticeOffset>& offsets, const std::vector<bool>& is_border) {
  OffLattice off;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (offsets[i] == kNone) continue;
    ++off.vertices;
    off.only_border = off.only_border && is_border[i];
  }
  return off;
}

/// Vertices that were joined come in rows.
struct MovedContexts {
  std::array<ProbabilityModel, 2> after;
  bool last = false;

  ProbabilityModel& next() { return after[last ? 1 : 0]; }
};

int bits_of(int coarsening) {
  return std::countr_zero(static_cast<unsigned>(coarsening));
}

}  // namespace

// Around a closed fan every neighbour begins one triangle's far edge and ends another's: the sum of their differences
// is zero.
std::vector<bool> border_vertices(std::span<const Triangle> triangles, std::size_t vertices) {
  std::vector<std::int64_t> turned(vertices, 0);
  for (const auto& [a, b, c] : triangles) {
    turned[a] += std::int64_t{c} - b;
    turned[b] += std::int64_t{a} - c;
    turned[c] += std::int64_t{b} - a;
  }
  std::vector<bool> is_border(vertices);
  std::transform(turned.begin(), turned.end(), is_border.begin(), [](std::int64_t sum) { return sum != 0; });
  return is_border;
}

int coarsening_inside(const Submesh& submesh) {
  const int whole = coarsening_of(submesh);
  const auto is_border = border_vertices(submesh.triangles, submesh.positions.size());
  const auto border = static_cast<std::size_t>(std::count(is_border.begin(), is_border.end(), true));
  int best = 1;
  std::size_t fewest = 3 * submesh.positions.size() * static_cast<std::size_t>(bits_of(kMaxCoarsening / whole));
  for (int coarsening = 2 * whole; coarsening <= kMaxCoarsening; coarsening *= 2) {
    auto positions = submesh.positions;
    const auto off = off_lattice(take_offsets(positions, coarsening), is_border);
    if (!off.only_border) break;
    // Bits beyond those of the coarsest lattice.
    const auto own = 3 * submesh.positions.size() * static_cast<std::size_t>(bits_of(kMaxCoarsening / coarsening));
    const auto bits = own + 8 + border + 3 * off.vertices * static_cast<std::size_t>(bits_of(coarsening));
    if (bits >= fewest) continue;
    best = coarsening;
    fewest = bits;
  }
  return best;
}

std::vector<LatticeOffset> take_offsets(std::vector<Eigen::Vector3f>& positions, int coarsening) {
  std::vector<LatticeOffset> offsets(positions.size());
  const double spacing_m = coarsening * static_cast<double>(kLatticeSpacing_m);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double exact_m = positions[i][axis];
      const double coarse_m = std::floor(exact_m / spacing_m + 0.5) * spacing_m;
      offsets[i][static_cast<std::size_t>(axis)] =
          static_cast<std::int8_t>((exact_m - coarse_m) / static_cast<double>(kLatticeSpacing_m));
      positions[i][axis] = static_cast<float>(coarse_m);
    }
  }
  return offsets;
}

void encode_offsets(BitEncoder& out, std::span<const LatticeOffset> offsets, const std::vector<bool>& is_border,
                    int coarsening) {
  MovedContexts is_moved;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (!is_border[i]) continue;
    out.encode(is_moved.next(), offsets[i] != kNone);
    is_moved.last = offsets[i] != kNone;
    if (!is_moved.last) continue;
    for (const int step : offsets[i])
      out.encode_bypass(static_cast<std::uint32_t>(step + coarsening / 2), bits_of(coarsening));
  }
}

Status decode_offsets(BitDecoder& in, const std::vector<bool>& is_border, int coarsening,
                      std::span<Eigen::Vector3f> positions) {
  MovedContexts is_moved;
  bool is_any_moved = false;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!is_on_lattice(positions[i], coarsening))
      return fail("positions are not on the lattice that the border is beside");
    if (!is_border[i]) continue;
    is_moved.last = in.decode(is_moved.next());
    if (!is_moved.last) continue;
    Eigen::Vector3f steps;
    for (auto& step : steps)
      step = static_cast<float>(static_cast<int>(in.decode_bypass(bits_of(coarsening))) - coarsening / 2);
    if (steps.isZero(0)) return fail("a vertex of the border is said to be moved, and is not");
    positions[i] += steps * kLatticeSpacing_m;
    is_any_moved = true;
  }
  return is_any_moved ? Status{} : fail("no vertex of the border is moved");
}

}  // namespace meshloop
