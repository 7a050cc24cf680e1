#include "server/adjust/find_moves.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "server/adjust/move_along.h"
#include "server/adjust/move_edits.h"
#include "server/adjust/move_search.h"

namespace meshloop::adjust {
namespace {

constexpr double kLeastChanged_px = 30;
constexpr double kLeastVisible_px = 150;
/// Of what is seen of a part.
constexpr double kLeastChangedShare = 0.02;
constexpr std::size_t kMostParts = 8;
/// Less is no region: as few as a region of the comparison has.
constexpr double kLeastLeft_px = 60;
/// Things of one snapshot that are looked for: where more have changed, it is a pose that is wrong or another room.
constexpr int kMostTries = 16;
/// Of what faces the camera: what reaches farther out of the picture is surroundings, or cannot be checked.
constexpr double kMostOutside = 0.15;
/// Nodes with more are surroundings, not things.
constexpr std::size_t kMostTriangles = 250'000;

/// Pixels.
struct Seen {
  double visible = 0;
  double changed = 0;
};

bool may_have_moved(const MoveScene& scene, const Seen& seen) {
  return seen.visible >= scene.scaled_pixels(kLeastVisible_px) &&
         seen.changed >= scene.scaled_pixels(kLeastChanged_px) && seen.changed >= kLeastChangedShare * seen.visible;
}

/// By position in Model::nodes.
std::vector<Seen> nodes_seen(const MoveScene& scene) {
  std::vector<Seen> nodes(scene.snapshot->model->nodes.size());
  const auto indices = scene.node_index.pixels();
  const auto open = scene.open.pixels();
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] == 0 || indices[i] > nodes.size()) continue;
    Seen& node = nodes[indices[i] - 1];
    ++node.visible;
    if (open[i] != 0) ++node.changed;
  }
  return nodes;
}

std::vector<Seen> parts_seen(const MoveScene& scene, std::size_t node_position, const PartNumbers& numbers) {
  constexpr float kSame_m = 0.01F;
  std::vector<Seen> parts(numbers.count);
  const Submesh& submesh = *scene.snapshot->model->nodes[node_position].submesh;
  const Pose T_camera_node = scene.T_camera_node(node_position);
  DepthBuffer drawn{projected_window(submesh.bounds(), T_camera_node, scene.camera(), 0)};
  draw(submesh, numbers.of_triangle, T_camera_node, scene.camera(), drawn);
  for (int y = drawn.window.y0; y < drawn.window.y1; ++y) {
    for (int x = drawn.window.x0; x < drawn.window.x1; ++x) {
      const float z = drawn.depth(x, y);
      if (!(z > 0) || scene.node_index(x, y) != node_position + 1) continue;
      if (std::abs(scene.expected(x, y) - z) > kSame_m) continue;
      Seen& part = parts[drawn.what[drawn.at(x, y)]];
      ++part.visible;
      if (scene.open(x, y) != 0) ++part.changed;
    }
  }
  return parts;
}

/// What is expected from now on.
void take_over(MoveScene& scene, const Part& part, const NewPlace& place, const WithoutPart& without) {
  const MoveCheck& check = place.check;
  scene.expected = without.background;
  scene.node_index = without.node_index;
  scene.threshold_m = without.threshold_m;
  std::size_t i = 0;
  for (int y = check.window.y0; y < check.window.y1; ++y) {
    for (int x = check.window.x0; x < check.window.x1; ++x, ++i) {
      scene.expected(x, y) = check.expected[i];
      scene.node_index(x, y) = check.node_index[i];
      scene.threshold_m(x, y) = check.threshold_m[i];
      if (check.is_explained[i] != 0) scene.open(x, y) = 0;
    }
  }
  scene.moved.push_back({part, place.T_camera_node});
  scene.closed.insert(scene.closed.end(), check.closes.begin(), check.closes.end());
}

/// What the search goes through, and what it finds.
struct Search {
  MoveScene scene;
  const ColorLookup* colors;
  NodeId* next_node_id;
  FoundMoves found;
  int tries = 0;
};

/// The positions of the nodes that belong to what was found at a new place; `place` then closes what they close too.
std::vector<std::size_t> take_along(Search& search, const Part& part, NewPlace& place) {
  std::vector<std::size_t> positions;
  const auto& nodes = search.scene.snapshot->model->nodes;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::size_t triangles = nodes[n].submesh->triangles.size();
    if (triangles > kMostTriangles || search.found.moving.count(nodes[n].id) > 0) continue;
    const auto along = moves_along(search.scene, part, place, n);
    if (!along) continue;
    take_over(search.scene, along->part, along->place, along->without);
    search.found.moving[nodes[n].id] = std::vector<bool>(triangles, true);
    auto& closes = place.check.closes;
    closes.insert(closes.end(), along->place.check.closes.begin(), along->place.check.closes.end());
    positions.push_back(n);
  }
  return positions;
}

bool try_part(Search& search, std::size_t node_position, std::vector<bool> triangles) {
  if (search.tries >= kMostTries) return false;
  const Snapshot& snapshot = *search.scene.snapshot;
  const Node& node = snapshot.model->nodes[node_position];
  auto& moving = search.found.moving;
  if (const auto known = moving.find(node.id); known != moving.end()) {
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (triangles[t] && known->second[t]) return false;
    }
  }
  const Part part = make_part(node, node_position, std::move(triangles));
  if (share_outside(search.scene, part, search.scene.T_camera_node(node_position)) > kMostOutside) return false;
  ++search.tries;
  const WithoutPart without = take_away(search.scene, part);
  auto place = find_new_place(search.scene, part, without, *search.colors);
  if (!place) return false;
  take_over(search.scene, part, *place, without);
  auto& all = moving.try_emplace(node.id, part.triangles.size(), false).first->second;
  for (std::size_t t = 0; t < all.size(); ++t) all[t] = all[t] || part.triangles[t];
  const auto along = take_along(search, part, *place);
  search.found.proposals.push_back(propose_move(snapshot, part, *place, along, *search.next_node_id));
  return true;
}

void try_parts(Search& search, std::size_t node_position, const PartNumbers& numbers) {
  const auto seen = parts_seen(search.scene, node_position, numbers);
  std::vector<std::uint32_t> order;
  for (std::uint32_t part = 0; part < numbers.count; ++part) {
    if (may_have_moved(search.scene, seen[part])) order.push_back(part);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return seen[a].changed > seen[b].changed; });
  if (order.size() > kMostParts) order.resize(kMostParts);
  for (const auto part : order) {
    std::vector<bool> triangles;
    triangles.reserve(numbers.of_triangle.size());
    for (const auto number : numbers.of_triangle) triangles.push_back(number == part);
    (void)try_part(search, node_position, std::move(triangles));
  }
}

void try_node(Search& search, std::size_t node_position, const Seen& seen) {
  const std::size_t triangles = search.scene.snapshot->model->nodes[node_position].submesh->triangles.size();
  if (triangles > kMostTriangles || seen.changed < search.scene.scaled_pixels(kLeastChanged_px)) return;
  if (may_have_moved(search.scene, seen) && try_part(search, node_position, std::vector<bool>(triangles, true))) return;
  const PartNumbers numbers = number_parts(*search.scene.snapshot->model->nodes[node_position].submesh);
  if (numbers.count > 1) try_parts(search, node_position, numbers);
}

/// The regions with the pixels that are open still. What is left of a closed one gets a new id: the move has the old
/// one.
RegionMap regions_left(const MoveScene& scene) {
  RegionMap left = *scene.snapshot->regions;
  RegionId next_id = 1;
  for (const auto& region : left.regions) next_id = std::max(next_id, region.id + 1);
  std::map<RegionId, RegionId> new_id;
  for (auto& region : left.regions) {
    const bool is_closed = std::find(scene.closed.begin(), scene.closed.end(), region.id) != scene.closed.end();
    const RegionId id = is_closed ? next_id++ : region.id;
    new_id[region.id] = id;
    region.id = id;
    if (region.confirmed && region.kind != ChangeKind::none) region.pixels = 0;
  }
  std::map<RegionId, int> open;
  for (std::size_t i = 0; i < left.ids.size(); ++i) {
    RegionId& id = left.ids.pixels()[i];
    if (id == 0 || scene.kind_of_region(id) == ChangeKind::none) continue;
    const RegionId still = scene.open.pixels()[i];
    id = still == 0 ? 0 : new_id[still];
    if (id != 0) ++open[id];
  }
  for (auto& region : left.regions) {
    if (const auto pixels = open.find(region.id); pixels != open.end()) region.pixels = pixels->second;
  }
  std::set<RegionId> too_small;
  std::erase_if(left.regions, [&](const Region& region) {
    const bool is_small = region.pixels < (region.confirmed ? scene.scaled_pixels(kLeastLeft_px) : 0);
    if (is_small) too_small.insert(region.id);
    return is_small;
  });
  for (auto& id : left.ids.pixels()) {
    if (too_small.count(id) > 0) id = 0;
  }
  return left;
}

}  // namespace

FoundMoves find_moves(const Snapshot& snapshot, const ColorLookup& colors, NodeId& next_node_id) {
  const auto& regions = snapshot.regions->regions;
  if (std::none_of(regions.begin(), regions.end(), [](const Region& region) { return region.confirmed; })) return {};
  Search search{MoveScene{snapshot}, &colors, &next_node_id, {}, 0};
  const auto seen = nodes_seen(search.scene);
  std::vector<std::size_t> order;
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (seen[n].changed > 0) order.push_back(n);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return seen[a].changed > seen[b].changed; });
  for (const auto n : order) try_node(search, n, seen[n]);
  if (!search.found.proposals.empty()) search.found.left = regions_left(search.scene);
  return std::move(search.found);
}

}  // namespace meshloop::adjust
