#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// Readers refuse polygons of more corners: at worst the time grows with the cube of their number.
inline constexpr std::size_t kMostPolygonCorners = 2'000;

/// Appends the triangles of a polygon, with its winding: as they are for three corners, else by cutting ears off in the
/// plane of the polygon's area normal, so that concave polygons keep their outline. Corners are indices into
/// `positions`; a polygon that names a position which is not there, or has less than three corners, gives nothing and
/// returns false.
bool append_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> positions,
                    std::vector<Triangle>& triangles);

}  // namespace meshloop
