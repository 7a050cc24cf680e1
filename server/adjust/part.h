#pragma once
// What of a node could move by itself.
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/model.h"

namespace meshloop::adjust {

/// The connected parts of a submesh (triangles that share vertex positions), from 0.
struct PartNumbers {
  std::vector<std::uint32_t> of_triangle;
  std::uint32_t count = 0;
};
[[nodiscard]] PartNumbers number_parts(const Submesh& submesh);

/// A point of a surface with the outward normal there, in the node's frame.
struct SurfacePoint {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;
};

/// A rigid thing: some triangles of a node, or all of them.
struct Part {
  /// In Model::nodes.
  std::size_t node_position = 0;
  /// Of the node's submesh.
  std::vector<bool> triangles;
  bool is_whole_node = false;
  /// These triangles alone, in the node's frame.
  Submesh submesh;
  /// The submesh's triangles, counted: for `draw`.
  std::vector<std::uint32_t> counted;
  /// Spread evenly over the area, the same for the same part, in no particular order: any run of them is spread too.
  std::vector<SurfacePoint> points;
  /// Right-handed, as columns: normals of the largest faces that are square to each other, where there are such.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  /// Middle of the box along the axes, and half its diagonal, metres.
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 0;
};

/// The triangles must be some of the node's, with an area.
[[nodiscard]] Part make_part(const Node& node, std::size_t node_position, std::vector<bool> triangles);

}  // namespace meshloop::adjust
