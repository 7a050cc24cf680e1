#pragma once
// Where the model's surface ends, as the depth camera sees it.
#include <cstdint>
#include <optional>
#include <vector>

#include "common/geometry/camera.h"
#include "common/image/image.h"
#include "common/mesh/model.h"

namespace meshloop::adjust {

/// "None" among numbers of vertices.
inline constexpr std::uint32_t kNoVertex = 0xffffffff;

struct BorderVertex {
  /// In the world, as the node's own vertex.
  Eigen::Vector3f p_world;
  /// Column, row and depth in metres; depth 0 or less behind the camera.
  Eigen::Vector3f in_picture;
  std::optional<Rgb8> color;
  /// Along the border, with the surface on the left as it is seen from its front; kNoVertex where the border ends, or
  /// meets another one.
  std::uint32_t next = kNoVertex;
  std::uint32_t previous = kNoVertex;
};

using OpenBorder = std::vector<BorderVertex>;

/// Column, row and depth of a point of the world.
[[nodiscard]] Eigen::Vector3f in_picture(const Eigen::Vector3f& p_world, const Camera& camera,
                                         const Eigen::Isometry3f& T_camera_world);

/// Edges of the model with a triangle on one side only, as far as they pass through the marked pixels (not 0). Nodes
/// that meet in the same lattice points are one surface there. Nodes above 250,000 triangles are left out.
[[nodiscard]] OpenBorder open_border(const Model& model, const Camera& camera, const Eigen::Isometry3f& T_camera_world,
                                     const Image<std::uint8_t>& marked);

}  // namespace meshloop::adjust
