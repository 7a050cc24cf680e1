#include "server/adjust/own_pixels.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "common/base/connected.h"
#include "server/adjust/depth_buffer.h"
#include "server/adjust/places.h"

namespace meshloop::adjust {
namespace {

/// How many measured pixels show something, and how many of them are seen through.
struct Seen {
  int measured = 0;
  int through = 0;

  [[nodiscard]] bool speaks_against() const { return 2 * through < measured; }
};

/// Of all triangles of the node, by position: what is not marked hides as well.
std::vector<Seen> count_pixels(const Snapshot& snapshot, const VisibleSurface& surface, std::size_t node_position) {
  const Node& node = snapshot.model->nodes[node_position];
  const Camera& camera = snapshot.rig->depth;
  const Pose T_camera_node = snapshot.depth_pose.T_camera_world * node.T_world_node;
  DepthBuffer drawn{projected_window(node.submesh->bounds(), T_camera_node, camera, 0)};
  std::vector<std::uint32_t> numbers(node.submesh->triangles.size());
  std::iota(numbers.begin(), numbers.end(), 0U);
  draw(*node.submesh, numbers, T_camera_node, camera, drawn);
  std::vector<Seen> seen(numbers.size());
  for (int y = drawn.window.y0; y < drawn.window.y1; ++y) {
    for (int x = drawn.window.x0; x < drawn.window.x1; ++x) {
      const double z = drawn.depth(x, y);
      if (!(z > 0) || !(snapshot.frame->depth(x, y) > 0) || !surface.is_expected(x, y, node_position, z)) continue;
      Seen& triangle = seen[drawn.what[drawn.at(x, y)]];
      ++triangle.measured;
      if (surface.is_seen_through(x, y, z)) ++triangle.through;
    }
  }
  return seen;
}

/// For each marked triangle a number that it shares with those it hangs together with by marked ones.
std::vector<std::uint32_t> pieces_of_what_goes(const Submesh& submesh, const std::vector<RegionId>& marks) {
  const auto places = places_of(submesh.positions);
  Connected connected{places.size()};
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] == 0) continue;
    const auto& [a, b, c] = submesh.triangles[t];
    connected.join(places[a], places[b]);
    connected.join(places[b], places[c]);
  }
  std::vector<std::uint32_t> pieces(marks.size(), 0);
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] != 0) pieces[t] = connected.first_of(places[submesh.triangles[t][0]]);
  }
  return pieces;
}

}  // namespace

void keep_what_only_touches(const Snapshot& snapshot, const VisibleSurface& surface, std::size_t node_position,
                            const std::vector<Sighting>& corners, std::vector<RegionId>& marks) {
  if (std::all_of(marks.begin(), marks.end(), [](RegionId id) { return id == 0; })) return;
  const Submesh& submesh = *snapshot.model->nodes[node_position].submesh;
  const auto of_triangle = count_pixels(snapshot, surface, node_position);
  const auto pieces = pieces_of_what_goes(submesh, marks);
  std::vector<Seen> of_piece(submesh.positions.size());
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] == 0) continue;
    of_piece[pieces[t]].measured += of_triangle[t].measured;
    of_piece[pieces[t]].through += of_triangle[t].through;
  }
  const auto goes = [&](std::size_t t) {
    if (of_piece[pieces[t]].speaks_against() || of_triangle[t].speaks_against()) return false;
    if (of_triangle[t].measured > 0) return true;
    const auto& triangle = submesh.triangles[t];
    return std::all_of(triangle.begin(), triangle.end(), [&](auto i) { return corners[i].seen_through != 0; });
  };
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] != 0 && !goes(t)) marks[t] = 0;
  }
}

}  // namespace meshloop::adjust
