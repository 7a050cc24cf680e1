#include "server/adjust/loose_pieces.h"

#include <algorithm>

#include "common/base/connected.h"
#include "server/adjust/places.h"

namespace meshloop::adjust {
namespace {

// By vertex: the same number for all that hang together through triangles that stay.
std::vector<std::uint32_t> pieces_of_what_stays(const Submesh& submesh, const std::vector<RegionId>& marks) {
  const auto places = places_of(submesh.positions);
  Connected connected{places.size()};
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] != 0) continue;
    const auto& [a, b, c] = submesh.triangles[t];
    connected.join(places[a], places[b]);
    connected.join(places[b], places[c]);
  }
  std::vector<std::uint32_t> pieces;
  pieces.reserve(places.size());
  for (const auto place : places) pieces.push_back(connected.first_of(place));
  return pieces;
}

/// What is known of a piece, by its number.
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
  const auto numbers = pieces_of_what_stays(submesh, marks);
  std::vector<Piece> pieces(numbers.size());
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] == 0) ++pieces[numbers[submesh.triangles[t][0]]].triangles;
    for (const auto i : submesh.triangles[t]) {
      if (marks[t] != 0) pieces[numbers[i]].neighbour = marks[t];
    }
  }
  const auto piece_of = [&](std::size_t t) -> Piece& { return pieces[numbers[submesh.triangles[t][0]]]; };
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
