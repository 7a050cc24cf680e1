#pragma once
// A submesh in levels of detail, so that drawing costs what the picture shows and not what the model holds.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// No vertex of the original surface lies farther from a group's replacement than this many times its error.
inline constexpr float kLargestPerError = 10;

/// Clusters that were replaced together by fewer triangles. On the border of a group nothing moves, so a picture may
/// show one group coarse and its neighbour fine, and no crack opens.
struct ClusterGroup {
  /// In the submesh's frame, metres: encloses the boxes of all groups that it goes back to, and their triangles.
  Eigen::AlignedBox3f bounds;
  /// Estimate of the root mean square distance of the original surface from the group's replacement (README.md), or
  /// more where the largest one asks for it; at least the errors of the groups that it goes back to.
  float error_m = 0;
  /// The clusters that it replaces: positions in ClusterHierarchy::members.
  std::uint32_t first_member = 0;
  std::uint32_t member_count = 0;
};

/// All normals of a cluster lie within a cone. In 127ths, as meshoptimizer rounds them to the safe side.
struct NormalCone {
  std::array<std::int8_t, 3> axis{};
  /// Sine of half the cone's angle; 127: the normals do not keep to a cone.
  std::int8_t cutoff = 127;
};

/// Neighbouring triangles that are drawn or left out together.
struct Cluster {
  /// Positions in ClusterHierarchy::triangles.
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
  Eigen::AlignedBox3f bounds;
  /// The group whose replacement it is a part of; none: original triangles.
  std::int32_t made_by = kNone;
  /// All its triangles are of this one of ClusterHierarchy::closed_parts; none: they are of several, or may be seen
  /// from either side.
  std::int32_t closed_part = kNone;
  NormalCone normals;

  static constexpr std::int32_t kNone = -1;
};

/// The replacements' vertices are the submesh's own. A picture of tolerance e shows a cluster when the group that made
/// it has an error of at most e and the one that replaces it has not: with bounds and errors that grow upwards this is
/// one surface without gaps or doubles, however e depends on the place.
struct ClusterHierarchy {
  /// Position k of a vertex buffer holds vertex vertex_order[k] of the submesh: those of the coarsest levels first, so
  /// that what a distant view needs lies together.
  std::vector<std::uint32_t> vertex_order;
  /// In positions of the vertex buffer. The original triangles come first, in another order than the submesh's.
  std::vector<Triangle> triangles;
  /// In the order of their triangles: those of original triangles first.
  std::vector<Cluster> clusters;
  std::vector<ClusterGroup> groups;
  /// Positions in `clusters`: each group's members one after the other, then those that nothing replaces. Clusters
  /// of triangles without area are in none.
  std::vector<std::uint32_t> members;
  std::uint32_t first_unreplaced = 0;
  /// Boxes around the parts of the surface that are closed and face outwards. Whoever looks at one from outside sees
  /// none of its triangles that face away.
  std::vector<Eigen::AlignedBox3f> closed_parts;
};

/// 3 to 5 us a triangle on one core. The submesh must be valid.
[[nodiscard]] ClusterHierarchy build_hierarchy(const Submesh& submesh);

}  // namespace meshloop
