#pragma once
// A cluster while the hierarchy is built. Used inside this room.
#include <cstdint>
#include <vector>

#include "common/detail/cluster_hierarchy.h"

namespace meshloop {

struct WorkingCluster {
  /// Vertices of the submesh; those at one place are one vertex.
  std::vector<Triangle> triangles;
  Sphere bounds;
  /// Position in ClusterHierarchy::clusters.
  std::uint32_t index = 0;
};

/// Encloses all of the vertices; within a few percent of the smallest.
[[nodiscard]] Sphere bounding_sphere(const std::vector<Eigen::Vector3f>& positions,
                                     const std::vector<Triangle>& triangles);
/// Encloses both.
[[nodiscard]] Sphere joined(const Sphere& a, const Sphere& b);

}  // namespace meshloop
