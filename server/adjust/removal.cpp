#include "server/adjust/removal.h"

#include <algorithm>

#include "server/adjust/loose_pieces.h"
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

void collect(const Node& node, const std::vector<RegionId>& marks, std::map<RegionId, RemovedTriangles>& removed) {
  std::map<RegionId, std::vector<bool>> masks;
  for (std::size_t t = 0; t < marks.size(); ++t) {
    if (marks[t] == 0) continue;
    auto& mask = masks[marks[t]];
    if (mask.empty()) mask.assign(marks.size(), false);
    mask[t] = true;
  }
  for (auto& [region, mask] : masks) removed[region].emplace_back(node.id, std::move(mask));
}

}  // namespace

std::map<RegionId, RemovedTriangles> find_removed(const Snapshot& snapshot, const AdjustOptions& options) {
  const VisibleSurface surface{snapshot};
  std::map<RegionId, RemovedTriangles> removed;
  for (const auto position : surface.nodes_in_removal_regions()) {
    const Node& node = snapshot.model->nodes[position];
    std::vector<Sighting> vertices;
    vertices.reserve(node.submesh->positions.size());
    for (const auto& p : node.submesh->positions) {
      vertices.push_back(surface.look_at(node.T_world_node * p.cast<double>(), position));
    }
    auto marks = mark_triangles(surface, node, position, vertices);
    const auto in_sight = [&](std::size_t t) {
      const auto& [a, b, c] = node.submesh->triangles[t];
      return vertices[a].sight == Sight::clear && vertices[b].sight == Sight::clear &&
             vertices[c].sight == Sight::clear && look_at_center(surface, node, position, t).sight == Sight::clear;
    };
    take_loose_pieces(*node.submesh, in_sight, options.min_patch_triangles, marks);
    collect(node, marks, removed);
  }
  return removed;
}

Edit removal_edit(const Node& node, const std::vector<bool>& removed) {
  std::vector<bool> keep = removed;
  keep.flip();
  if (std::none_of(keep.begin(), keep.end(), [](bool kept) { return kept; })) return RemoveNode{node.id};
  return ReplaceSubmesh{node.id, std::make_shared<const Submesh>(keep_triangles(*node.submesh, keep))};
}

}  // namespace meshloop::adjust
