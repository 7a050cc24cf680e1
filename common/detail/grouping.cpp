#include "common/detail/grouping.h"

#include <algorithm>
#include <map>
#include <utility>

namespace meshloop {
namespace {

struct BorderEdge {
  std::uint64_t vertices;
  std::uint32_t cluster;
  friend auto operator<=>(const BorderEdge&, const BorderEdge&) = default;
};

/// For each cluster its neighbours with the number of edges they share.
using Neighbours = std::vector<std::vector<std::pair<std::uint32_t, int>>>;

std::uint64_t undirected(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

/// Edges that the cluster has once.
void append_border(const WorkingCluster& cluster, std::uint32_t index, std::vector<std::uint64_t>& scratch,
                   std::vector<BorderEdge>& border) {
  scratch.clear();
  for (const auto& [a, b, c] : cluster.triangles) {
    scratch.insert(scratch.end(), {undirected(a, b), undirected(b, c), undirected(c, a)});
  }
  std::sort(scratch.begin(), scratch.end());
  for (std::size_t i = 0; i < scratch.size();) {
    std::size_t end = i + 1;
    while (end < scratch.size() && scratch[end] == scratch[i]) ++end;
    if (end == i + 1) border.push_back({scratch[i], index});
    i = end;
  }
}

Neighbours neighbours_of(std::span<const WorkingCluster> clusters) {
  std::vector<BorderEdge> border;
  std::vector<std::uint64_t> scratch;
  for (std::uint32_t i = 0; i < clusters.size(); ++i) append_border(clusters[i], i, scratch, border);
  std::sort(border.begin(), border.end());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> shared;
  for (std::size_t i = 0; i + 1 < border.size(); ++i) {
    if (border[i].vertices != border[i + 1].vertices) continue;
    shared.emplace_back(border[i].cluster, border[i + 1].cluster);
    shared.emplace_back(border[i + 1].cluster, border[i].cluster);
  }
  std::sort(shared.begin(), shared.end());
  Neighbours neighbours(clusters.size());
  for (const auto& [one, other] : shared) {
    auto& of_one = neighbours[one];
    if (of_one.empty() || of_one.back().first != other) of_one.emplace_back(other, 0);
    ++of_one.back().second;
  }
  return neighbours;
}

/// Grows one group from a seed.
class Grower {
 public:
  Grower(const Neighbours& neighbours, std::vector<bool>& taken) : neighbours_{neighbours}, taken_{taken} {}

  std::vector<std::uint32_t> grow(std::uint32_t seed, std::size_t largest) {
    std::vector<std::uint32_t> group;
    std::map<std::uint32_t, int> edges_to;
    for (std::uint32_t next = seed;;) {
      group.push_back(next);
      taken_[next] = true;
      edges_to.erase(next);
      for (const auto& [other, edges] : neighbours_[next]) {
        if (!taken_[other]) edges_to[other] += edges;
      }
      if (group.size() == largest || edges_to.empty()) return group;
      next = std::max_element(edges_to.begin(), edges_to.end(), [](const auto& a, const auto& b) {
               return a.second < b.second;
             })->first;
    }
  }

 private:
  const Neighbours& neighbours_;
  std::vector<bool>& taken_;
};

float distance(const WorkingCluster& a, const WorkingCluster& b) {
  return (a.bounds.center() - b.bounds.center()).squaredNorm();
}

/// Joins groups that came out small to the group before: what has no common edge (separate pieces, specks) would
/// otherwise never be simplified further.
void merge_small(std::vector<std::vector<std::uint32_t>>& groups, std::span<const WorkingCluster> clusters,
                 std::size_t largest) {
  constexpr std::size_t kLookBack = 8;
  std::vector<std::vector<std::uint32_t>> merged;
  for (auto& group : groups) {
    std::size_t best = merged.size();
    for (std::size_t i = merged.size() - std::min(merged.size(), kLookBack); i < merged.size(); ++i) {
      if (merged[i].size() + group.size() > largest) continue;
      if (best == merged.size() || distance(clusters[merged[i].front()], clusters[group.front()]) <
                                       distance(clusters[merged[best].front()], clusters[group.front()])) {
        best = i;
      }
    }
    if (2 * group.size() > largest || best == merged.size()) {
      merged.push_back(std::move(group));
    } else {
      merged[best].insert(merged[best].end(), group.begin(), group.end());
    }
  }
  groups = std::move(merged);
}

}  // namespace

std::vector<std::vector<std::uint32_t>> group_neighbours(std::span<const WorkingCluster> clusters,
                                                         std::size_t largest) {
  const Neighbours neighbours = neighbours_of(clusters);
  std::vector<bool> taken(clusters.size(), false);
  Grower grower{neighbours, taken};
  std::vector<std::vector<std::uint32_t>> groups;
  for (std::uint32_t seed = 0; seed < clusters.size(); ++seed) {
    if (!taken[seed]) groups.push_back(grower.grow(seed, largest));
  }
  merge_small(groups, clusters, largest);
  return groups;
}

}  // namespace meshloop
