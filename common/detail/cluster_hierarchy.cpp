#include "common/detail/cluster_hierarchy.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/detail/closed_parts.h"
#include "common/detail/grouping.h"
#include "common/detail/local_mesh.h"
#include "common/detail/simplify.h"
#include "common/detail/working_cluster.h"

namespace meshloop {
namespace {

// Small groups follow the tolerance closely where depth changes, and cost little when few of them are looked at.
constexpr std::size_t kTrianglesPerCluster = 24;
constexpr std::size_t kVerticesPerCluster = 64;
constexpr std::size_t kClustersPerGroup = 16;
/// A group that keeps more of its triangles than this waits for other neighbours on the next level.
constexpr double kWorthwhile = 0.85;

/// Cuts into connected clusters.
std::vector<std::vector<Triangle>> cut(const LocalMesh& local) {
  const auto& positions = local.positions;
  const auto& triangles = local.triangles;
  const std::size_t indices = 3 * triangles.size();
  const std::size_t most = meshopt_buildMeshletsBound(indices, kVerticesPerCluster, kTrianglesPerCluster);
  std::vector<meshopt_Meshlet> pieces(most);
  std::vector<unsigned> vertices(most * kVerticesPerCluster);
  std::vector<unsigned char> corners(most * kTrianglesPerCluster * 3);
  pieces.resize(meshopt_buildMeshlets(pieces.data(), vertices.data(), corners.data(), triangles.front().data(), indices,
                                      positions.front().data(), positions.size(), sizeof(Eigen::Vector3f),
                                      kVerticesPerCluster, kTrianglesPerCluster, 0));
  std::vector<std::vector<Triangle>> clusters;
  for (const auto& piece : pieces) {
    auto& cluster = clusters.emplace_back();
    for (unsigned t = 0; t < piece.triangle_count; ++t) {
      const auto vertex = [&](unsigned k) {
        return vertices[piece.vertex_offset + corners[piece.triangle_offset + 3 * t + k]];
      };
      cluster.push_back(local.outside({vertex(0), vertex(1), vertex(2)}));
    }
  }
  return clusters;
}

NormalCone normals_of(const std::vector<Eigen::Vector3f>& positions, const std::vector<Triangle>& triangles) {
  const meshopt_Bounds bounds =
      meshopt_computeClusterBounds(triangles.front().data(), 3 * triangles.size(), positions.front().data(),
                                   positions.size(), sizeof(Eigen::Vector3f));
  NormalCone cone;
  std::copy(std::begin(bounds.cone_axis_s8), std::end(bounds.cone_axis_s8), cone.axis.begin());
  cone.cutoff = bounds.cone_cutoff_s8;
  return cone;
}

class Builder {
 public:
  explicit Builder(const Submesh& submesh) : submesh_{submesh}, cutter_{submesh.positions} {}

  ClusterHierarchy build() {
    weld();
    find_closed_parts();
    add_finest();
    while (active_.size() > 1 && add_level()) {
    }
    result_.first_unreplaced = static_cast<std::uint32_t>(result_.members.size());
    for (const auto& cluster : active_) result_.members.push_back(cluster.index);
    order_vertices();
    return std::move(result_);
  }

 private:
  /// Vertices at one place become one, so that a seam of colours is no border.
  void weld() {
    const auto& triangles = submesh_.triangles;
    std::vector<Triangle> welded(triangles.size());
    meshopt_generateShadowIndexBuffer(welded.front().data(), triangles.front().data(), 3 * triangles.size(),
                                      submesh_.positions.front().data(), submesh_.positions.size(),
                                      sizeof(Eigen::Vector3f), sizeof(Eigen::Vector3f));
    place_of_.resize(submesh_.positions.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) place_of_[triangles[t][k]] = welded[t][k];
    }
  }

  void find_closed_parts() {
    std::vector<Triangle> welded;
    welded.reserve(submesh_.triangles.size());
    for (const auto& [a, b, c] : submesh_.triangles) welded.push_back({place_of_[a], place_of_[b], place_of_[c]});
    ClosedParts parts = closed_parts_of(submesh_.positions, welded);
    part_of_ = std::move(parts.of_vertex);
    result_.closed_parts = std::move(parts.bounds);
  }

  void add_finest() {
    for (auto& original : cut(cutter_.take(submesh_.triangles))) {
      WorkingCluster cluster;
      for (const auto& [a, b, c] : original) {
        const Triangle welded{place_of_[a], place_of_[b], place_of_[c]};
        const bool has_area = welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0];
        if (has_area) cluster.triangles.push_back(welded);
      }
      cluster.bounds = bounds_of(submesh_.positions, original);
      cluster.area_m2 = area_of(cluster.triangles);
      cluster.index = add(original, cluster.bounds, Cluster::kNone);
      if (!cluster.triangles.empty()) active_.push_back(std::move(cluster));
    }
  }

  float area_of(const std::vector<Triangle>& triangles) const {
    return std::accumulate(triangles.begin(), triangles.end(), 0.0f, [&](float sum, const Triangle& triangle) {
      return sum + normal_of(submesh_.positions, triangle).norm() / 2;
    });
  }

  std::uint32_t add(const std::vector<Triangle>& triangles, const Eigen::AlignedBox3f& bounds, std::int32_t made_by) {
    Cluster cluster;
    cluster.first_triangle = static_cast<std::uint32_t>(result_.triangles.size());
    cluster.triangle_count = static_cast<std::uint32_t>(triangles.size());
    cluster.bounds = bounds;
    cluster.made_by = made_by;
    cluster.closed_part = closed_part_of(triangles);
    if (cluster.closed_part != Cluster::kNone) cluster.normals = normals_of(submesh_.positions, triangles);
    result_.triangles.insert(result_.triangles.end(), triangles.begin(), triangles.end());
    result_.clusters.push_back(cluster);
    return static_cast<std::uint32_t>(result_.clusters.size() - 1);
  }

  /// None unless all vertices are of the same part.
  std::int32_t closed_part_of(const std::vector<Triangle>& triangles) const {
    const std::int32_t part = part_of_[place_of_[triangles.front().front()]];
    const bool is_one = std::all_of(triangles.begin(), triangles.end(), [&](const Triangle& triangle) {
      return std::all_of(triangle.begin(), triangle.end(),
                         [&](std::uint32_t vertex) { return part_of_[place_of_[vertex]] == part; });
    });
    return is_one ? part : Cluster::kNone;
  }

  /// False when the level brought too little for another one to be worth its work.
  bool add_level() {
    constexpr double kStanding = 0.95;
    std::vector<WorkingCluster> next;
    std::size_t before = 0;
    std::size_t after = 0;
    for (const auto& cluster : active_) before += cluster.triangles.size();
    for (const auto& group : group_neighbours(active_, kClustersPerGroup)) replace(group, next);
    for (const auto& cluster : next) after += cluster.triangles.size();
    active_ = std::move(next);
    return static_cast<double>(after) < kStanding * static_cast<double>(before);
  }

  void replace(const std::vector<std::uint32_t>& members, std::vector<WorkingCluster>& next) {
    std::vector<Triangle> all;
    for (const auto member : members) {
      const auto& triangles = active_[member].triangles;
      all.insert(all.end(), triangles.begin(), triangles.end());
    }
    const LocalMesh part = cutter_.take(all);
    Simplified simple = simplify_to_half(part);
    if (simple.triangles.empty() ||
        static_cast<double>(simple.triangles.size()) > kWorthwhile * static_cast<double>(all.size())) {
      for (const auto member : members) next.push_back(std::move(active_[member]));
      return;
    }
    const auto index = static_cast<std::int32_t>(result_.groups.size());
    add_group(members, simple.deviation);
    for (auto& triangle : simple.triangles) triangle = part.outside(triangle);
    for (auto& triangles : cut(cutter_.take(simple.triangles))) {
      WorkingCluster cluster;
      cluster.bounds = bounds_of(submesh_.positions, triangles);
      cluster.area_m2 = area_of(triangles);
      cluster.index = add(triangles, cluster.bounds, index);
      cluster.triangles = std::move(triangles);
      next.push_back(std::move(cluster));
    }
  }

  /// One level steps to either side of the one before, so mean squares add up; the largest distances may add as well.
  Deviation deviation_over(const std::vector<std::uint32_t>& members, const Deviation& last) const {
    float largest_m = 0;
    float worst_square = 0;
    float sum = 0;
    float area_m2 = 0;
    for (const auto member : members) {
      area_m2 += active_[member].area_m2;
      const std::int32_t made_by = result_.clusters[active_[member].index].made_by;
      if (made_by == Cluster::kNone) continue;
      const Deviation& earlier = deviations_[static_cast<std::size_t>(made_by)];
      const float square = earlier.rms_m * earlier.rms_m;
      largest_m = std::max(largest_m, earlier.largest_m);
      worst_square = std::max(worst_square, square);
      sum += active_[member].area_m2 * square;
    }
    const float below = area_m2 > 0 ? sum / area_m2 : 0;
    return {largest_m + last.largest_m, std::sqrt(std::max(worst_square, below + last.rms_m * last.rms_m))};
  }

  void add_group(const std::vector<std::uint32_t>& members, const Deviation& last) {
    ClusterGroup group;
    for (const auto member : members) {
      group.bounds.extend(active_[member].bounds);
      const std::int32_t made_by = result_.clusters[active_[member].index].made_by;
      if (made_by != Cluster::kNone) group.bounds.extend(result_.groups[static_cast<std::size_t>(made_by)].bounds);
    }
    const Deviation& deviation = deviations_.emplace_back(deviation_over(members, last));
    group.error_m = std::max(deviation.rms_m, deviation.largest_m / kLargestPerError);
    group.first_member = static_cast<std::uint32_t>(result_.members.size());
    group.member_count = static_cast<std::uint32_t>(members.size());
    for (const auto member : members) result_.members.push_back(active_[member].index);
    result_.groups.push_back(group);
  }

  void order_vertices() {
    constexpr std::uint32_t kUnplaced = ~0u;
    auto& order = result_.vertex_order;
    std::vector<std::uint32_t> position(submesh_.positions.size(), kUnplaced);
    for (auto cluster = result_.clusters.rbegin(); cluster != result_.clusters.rend(); ++cluster) {
      for (std::uint32_t t = 0; t < cluster->triangle_count; ++t) {
        for (auto& vertex : result_.triangles[cluster->first_triangle + t]) {
          auto& place = position[vertex];
          if (place == kUnplaced) {
            place = static_cast<std::uint32_t>(order.size());
            order.push_back(vertex);
          }
          vertex = place;
        }
      }
    }
  }

  const Submesh& submesh_;
  PartCutter cutter_;
  std::vector<std::uint32_t> place_of_;
  /// By vertex, of those that stand for a place: its closed part.
  std::vector<std::int32_t> part_of_;
  std::vector<WorkingCluster> active_;
  /// Of each group's replacement from the original surface.
  std::vector<Deviation> deviations_;
  ClusterHierarchy result_;
};

}  // namespace

ClusterHierarchy build_hierarchy(const Submesh& submesh) {
  return Builder{submesh}.build();
}

}  // namespace meshloop
