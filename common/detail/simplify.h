#pragma once
// One group of clusters to half its triangles. Used inside this room.
#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/detail/local_mesh.h"

namespace meshloop {

struct Simplified {
  /// Over the vertices of the part that was simplified.
  std::vector<Triangle> triangles;
  /// Largest distance from a vertex that was left out to the new triangles.
  float deviation_m = 0;
};

/// Vertices on the border (edges with one triangle) stay.
[[nodiscard]] Simplified simplify_to_half(const LocalMesh& part);

/// Squared distance of p to the triangle a, b, c.
[[nodiscard]] float squared_distance(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                     const Eigen::Vector3f& c);

}  // namespace meshloop
