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

/// A closed line in a plane: the corners' numbers, and where they lie.
struct FlatRing {
  std::vector<std::uint32_t> corners;
  std::vector<Eigen::Vector2d> points;
};

/// Appends the triangles of a polygon with holes, counter-clockwise. The first ring is the outer one,
/// counter-clockwise; the others lie in it, apart from each other, and run clockwise. Rings may touch each other and
/// themselves at corners, and have corners along a straight line, each of which gets its triangles. Each ring has three
/// corners or more.
void append_flat_polygon(std::vector<FlatRing> rings, std::vector<Triangle>& triangles);

}  // namespace meshloop
