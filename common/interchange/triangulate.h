#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// Appends the triangles of a polygon, with its winding: as they are for three corners, else by cutting ears off in the
/// plane of the polygon's area normal, so that concave polygons keep their outline. Corners are indices into
/// `positions`; a polygon that names a position which is not there, or has less than three corners, gives nothing and
/// returns false. Time grows with the square of the corners.
bool append_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> positions,
                    std::vector<Triangle>& triangles);

}  // namespace meshloop
