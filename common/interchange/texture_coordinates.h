#pragma once
#include <Eigen/Core>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// A textured surface for formats that know coordinates at vertices alone.
struct TexturedMesh {
  std::vector<Eigen::Vector3f> positions;
  /// One per position: 0 to 1 from left to right and from top to bottom of the picture, as glTF counts.
  std::vector<Eigen::Vector2f> coordinates;
  std::vector<Triangle> triangles;
};

/// The surface of a submesh with a texture. Programs interpolate coordinates evenly across a triangle, and a projection
/// does not: edges are halved until the texture is right to half a pixel at their middles. Both triangles at an edge
/// divide it alike, so that no crack opens; no more than ten times, nor when there are as many triangles as twice the
/// texture's pixels. The submesh must be valid.
[[nodiscard]] TexturedMesh with_coordinates(const Submesh& submesh);

}  // namespace meshloop
