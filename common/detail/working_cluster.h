#pragma once
// A cluster while the hierarchy is built. Used inside this room.
#include <cstdint>
#include <vector>

#include "common/detail/cluster_hierarchy.h"

namespace meshloop {

struct WorkingCluster {
  /// Vertices of the submesh; those at one place are one vertex.
  std::vector<Triangle> triangles;
  Eigen::AlignedBox3f bounds;
  float area_m2 = 0;
  /// Position in ClusterHierarchy::clusters.
  std::uint32_t index = 0;
};

[[nodiscard]] inline Eigen::AlignedBox3f bounds_of(const std::vector<Eigen::Vector3f>& positions,
                                                   const std::vector<Triangle>& triangles) {
  Eigen::AlignedBox3f bounds;
  for (const auto& triangle : triangles) {
    for (const auto vertex : triangle) bounds.extend(positions[vertex]);
  }
  return bounds;
}

}  // namespace meshloop
