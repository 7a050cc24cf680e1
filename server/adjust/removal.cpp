#include "server/adjust/removal.h"

#include <memory>
#include <utility>

#include "server/adjust/cut.h"
#include "server/adjust/cut_outlines.h"
#include "server/adjust/loose_pieces.h"
#include "server/adjust/own_pixels.h"
#include "server/adjust/visible_surface.h"

namespace meshloop::adjust {
namespace {

Sighting look_at_center(const VisibleSurface& surface, const Node& node, std::size_t node_position, std::size_t t) {
  const auto& [a, b, c] = node.submesh->triangles[t];
  const auto& p = node.submesh->positions;
  const Eigen::Vector3d center = (p[a] + p[b] + p[c]).cast<double>() / 3;
  return surface.look_at(node.T_world_node * center, node_position);
}

// The region that takes each triangle away, 0 for those that stay: all three vertices are seen through, or some are and
// so is the triangle's centre.
std::vector<RegionId> mark_triangles(const VisibleSurface& surface, const Node& node, std::size_t node_position,
                                     const std::vector<Sighting>& vertices) {
  const Submesh& submesh = *node.submesh;
  std::vector<RegionId> marks(submesh.triangles.size(), 0);
  for (std::size_t t = 0; t < marks.size(); ++t) {
    const auto& [a, b, c] = submesh.triangles[t];
    const auto in_a = vertices[a].seen_through;
    const auto in_b = vertices[b].seen_through;
    const auto in_c = vertices[c].seen_through;
    if (in_a == 0 && in_b == 0 && in_c == 0) continue;
    if (in_a != 0 && in_b != 0 && in_c != 0) {
      marks[t] = in_b == in_c ? in_b : in_a;
      continue;
    }
    marks[t] = look_at_center(surface, node, node_position, t).seen_through;
  }
  return marks;
}

/// Of one node, by region.
std::map<RegionId, Removal> by_region(const Node& node, const std::vector<RegionId>& marks,
                                      std::map<RegionId, CutOutlines> cuts) {
  std::map<RegionId, Removal> removals;
  const auto removal_of = [&](RegionId region) -> Removal& {
    const auto [entry, is_new] = removals.try_emplace(region);
    if (is_new) entry->second = {node.id, node.hash, std::vector<bool>(marks.size(), false), {}, node.T_world_node};
    return entry->second;
  };
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] != 0) removal_of(marks[t]).triangles[t] = true;
  }
  for (auto& [region, outlines] : cuts) removal_of(region).cuts = std::move(outlines);
  return removals;
}

std::map<RegionId, Removal> removals_of(const Snapshot& snapshot, const VisibleSurface& surface, std::size_t position,
                                        const AdjustOptions& options) {
  const Node& node = snapshot.model->nodes[position];
  std::vector<Sighting> vertices;
  vertices.reserve(node.submesh->positions.size());
  for (const auto& p : node.submesh->positions) {
    vertices.push_back(surface.look_at(node.T_world_node * p.cast<double>(), position));
  }
  LargeTriangles large = find_cut_outlines(snapshot, surface, position);
  auto marks = mark_triangles(surface, node, position, vertices);
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (large.is_shown[t]) marks[t] = 0;
  }
  keep_what_only_touches(snapshot, surface, position, vertices, marks);
  const auto in_sight = [&](std::size_t t) {
    // What is large is no crumb.
    if (large.is_large[t]) return false;
    const auto& [a, b, c] = node.submesh->triangles[t];
    return vertices[a].sight == Sight::clear && vertices[b].sight == Sight::clear &&
           vertices[c].sight == Sight::clear && look_at_center(surface, node, position, t).sight == Sight::clear;
  };
  take_loose_pieces(*node.submesh, in_sight, options.min_patch_triangles, marks);
  return by_region(node, marks, std::move(large.by_region));
}

}  // namespace

std::map<RegionId, std::vector<Removal>> find_removed(const Snapshot& snapshot, const AdjustOptions& options) {
  const VisibleSurface surface{snapshot};
  std::map<RegionId, std::vector<Removal>> removed;
  for (const auto position : surface.nodes_in_removal_regions()) {
    for (auto& [region, removal] : removals_of(snapshot, surface, position, options)) {
      removed[region].push_back(std::move(removal));
    }
  }
  return removed;
}

Removed remove_from(const Node& node, const Removal& removal) {
  CutSubmesh cut_submesh = cut(*node.submesh, removal);
  Removed removed{std::nullopt, cut_submesh.taken, cut_submesh.added};
  if (removed.taken == 0) return removed;
  if (cut_submesh.submesh.triangles.empty()) {
    removed.edit = RemoveNode{node.id};
  } else {
    removed.edit = ReplaceSubmesh{node.id, std::make_shared<const Submesh>(std::move(cut_submesh.submesh))};
  }
  return removed;
}

}  // namespace meshloop::adjust
