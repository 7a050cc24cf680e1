#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop::adjust {

/// Flips edges between two triangles until none of them lies in the circumcircle of its neighbour (Lawson 1977), so
/// that no triangle is thinner than its outline demands. Triangles are counter-clockwise with v downwards, as a camera
/// sees front faces, and do not overlap. `place` of a vertex is its place in the picture. For some hundred triangles.
void flip_to_delaunay(std::vector<Triangle>& triangles, const std::function<Eigen::Vector2f(std::uint32_t)>& place);

}  // namespace meshloop::adjust
