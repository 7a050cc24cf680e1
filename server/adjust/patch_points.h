#pragma once
// Vertices of a patch as points.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "common/geometry/camera.h"
#include "server/adjust/depth_grid.h"
#include "server/adjust/grid_mesh.h"
#include "server/adjust/straight_lines.h"

namespace meshloop::adjust {

/// In the depth camera's frame, metres. A vertex that was put onto a line has its place there, not its pixel's.
[[nodiscard]] std::vector<Eigen::Vector3f> back_project(const DepthGrid& grid, const VertexPlaces& moved,
                                                        const Camera& camera, const GridVertices& vertices);

[[nodiscard]] std::vector<Eigen::Vector3f> transformed(const Eigen::Isometry3f& T,
                                                       const std::vector<Eigen::Vector3f>& points);

}  // namespace meshloop::adjust
