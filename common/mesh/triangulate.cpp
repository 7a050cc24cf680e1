#include "common/interchange/triangulate.h"

#include <algorithm>
#include <cstddef>

namespace meshloop {
namespace {

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b, const Point& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The polygon in its own plane, counter-clockwise (Newell's normal).
std::vector<Point> flattened(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> positions) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Vector3d origin = positions[corners[0]].cast<double>();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d a = positions[corners[i]].cast<double>() - origin;
    const Eigen::Vector3d b = positions[corners[(i + 1) % corners.size()]].cast<double>() - origin;
    normal += a.cross(b);
  }
  if (!(normal.norm() > 0)) normal = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d x = normal.unitOrthogonal();
  const Eigen::Vector3d y = normal.normalized().cross(x);
  std::vector<Point> flat;
  flat.reserve(corners.size());
  for (const auto corner : corners) {
    const Eigen::Vector3d p = positions[corner].cast<double>() - origin;
    flat.emplace_back(p.dot(x), p.dot(y));
  }
  return flat;
}

bool is_ear(const std::vector<Point>& points, const std::vector<std::size_t>& rest, std::size_t at) {
  const std::size_t before = (at + rest.size() - 1) % rest.size();
  const std::size_t after = (at + 1) % rest.size();
  const Point &a = points[rest[before]], &b = points[rest[at]], &c = points[rest[after]];
  if (!(cross(a, b, c) > 0)) return false;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (i == before || i == at || i == after) continue;
    const Point& p = points[rest[i]];
    if (p == a || p == b || p == c) continue;
    if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

bool append_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> positions,
                    std::vector<Triangle>& triangles) {
  const auto exists = [&](std::uint32_t corner) { return corner < positions.size(); };
  if (corners.size() < 3 || !std::all_of(corners.begin(), corners.end(), exists)) return false;
  if (corners.size() == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
    return true;
  }
  const auto points = flattened(corners, positions);
  std::vector<std::size_t> rest(corners.size());
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = i;
  while (rest.size() >= 3) {
    std::size_t ear = 0;
    while (ear < rest.size() && !is_ear(points, rest, ear)) ++ear;
    // A polygon that crosses itself may have none left; what remains is still covered.
    if (ear == rest.size()) ear = 0;
    const std::size_t before = (ear + rest.size() - 1) % rest.size();
    const std::size_t after = (ear + 1) % rest.size();
    triangles.push_back({corners[rest[before]], corners[rest[ear]], corners[rest[after]]});
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return true;
}

}  // namespace meshloop
