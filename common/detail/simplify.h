#pragma once
// One group of clusters to half its triangles. Used inside this room.
#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/detail/local_mesh.h"

namespace meshloop {

/// How far a surface lies from the one that replaces it.
struct Deviation {
  /// Of its vertices.
  float largest_m = 0;
  /// Root mean square over its area.
  float rms_m = 0;
};

struct Simplified {
  /// Over the vertices of the part that was simplified.
  std::vector<Triangle> triangles;
  Deviation deviation;
};

/// Vertices on the border (edges with one triangle) stay.
[[nodiscard]] Simplified simplify_to_half(const LocalMesh& part);

/// As long as twice the triangle's area.
[[nodiscard]] Eigen::Vector3f normal_of(const std::vector<Eigen::Vector3f>& positions, const Triangle& triangle);

/// Squared distance of p to the triangle a, b, c.
[[nodiscard]] float squared_distance(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                                     const Eigen::Vector3f& c);

}  // namespace meshloop
