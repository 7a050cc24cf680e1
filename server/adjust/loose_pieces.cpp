#include "server/adjust/loose_pieces.h"

#include <algorithm>
#include <numeric>

#include "server/adjust/places.h"

namespace meshloop::adjust {
namespace {

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Triangles that stay and are connected have the same root among the welded vertices.
std::vector<std::uint32_t> roots_of_what_stays(const Submesh& submesh, const std::vector<RegionId>& marks) {
  const auto welded = places_of(submesh.positions);
  std::vector<std::uint32_t> parent(welded.size());
  std::iota(parent.begin(), parent.end(), 0u);
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] != 0) continue;
    const auto root = root_of(parent, welded[submesh.triangles[t][0]]);
    for (const auto i : submesh.triangles[t]) parent[root_of(parent, welded[i])] = root;
  }
  std::vector<std::uint32_t> roots(welded.size());
  for (std::size_t i = 0; i < roots.size(); ++i) roots[i] = root_of(parent, welded[i]);
  return roots;
}

/// What is known of a piece, by its root vertex.
struct Piece {
  std::size_t triangles = 0;
  bool in_sight = true;
  /// A region that removed a neighbour; 0 when none did.
  RegionId neighbour = 0;
};

}  // namespace

void take_loose_pieces(const Submesh& submesh, const std::function<bool(std::size_t)>& in_sight, std::size_t smallest,
                       std::vector<RegionId>& marks) {
  if (std::all_of(marks.begin(), marks.end(), [](RegionId id) { return id == 0; })) return;
  const auto roots = roots_of_what_stays(submesh, marks);
  std::vector<Piece> pieces(roots.size());
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] == 0) ++pieces[roots[submesh.triangles[t][0]]].triangles;
    for (const auto i : submesh.triangles[t]) {
      if (marks[t] != 0) pieces[roots[i]].neighbour = marks[t];
    }
  }
  const auto piece_of = [&](std::size_t t) -> Piece& { return pieces[roots[submesh.triangles[t][0]]]; };
  const auto may_go = [&](std::size_t t) {
    return marks[t] == 0 && piece_of(t).triangles < smallest && piece_of(t).neighbour != 0;
  };
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (may_go(t) && !in_sight(t)) piece_of(t).in_sight = false;
  }
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (may_go(t) && piece_of(t).in_sight) marks[t] = piece_of(t).neighbour;
  }
}

}  // namespace meshloop::adjust
