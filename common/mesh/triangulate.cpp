#include "common/mesh/triangulate.h"

#include <algorithm>
#include <cstddef>
#include <utility>

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

/// Do the segments a b and c d cross, other than in a common end?
bool cross_each_other(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (a == c || a == d || b == c || b == d) return false;
  return cross(a, b, c) * cross(a, b, d) <= 0 && cross(c, d, a) * cross(c, d, b) <= 0;
}

bool blocks(const FlatRing& ring, const Point& a, const Point& b) {
  for (std::size_t i = 0; i < ring.points.size(); ++i) {
    if (cross_each_other(a, b, ring.points[i], ring.points[(i + 1) % ring.points.size()])) return true;
  }
  return false;
}

/// The shortest bridge from a ring to a hole in it that crosses nothing; without one the shortest of all.
std::pair<std::size_t, std::size_t> bridge(const FlatRing& ring, const FlatRing& hole,
                                           std::span<const FlatRing> others) {
  std::vector<std::pair<double, std::pair<std::size_t, std::size_t>>> bridges;
  for (std::size_t i = 0; i < ring.points.size(); ++i) {
    for (std::size_t k = 0; k < hole.points.size(); ++k) {
      bridges.push_back({(ring.points[i] - hole.points[k]).squaredNorm(), {i, k}});
    }
  }
  std::sort(bridges.begin(), bridges.end());
  for (const auto& [length, ends] : bridges) {
    const Point& from = ring.points[ends.first];
    const Point& to = hole.points[ends.second];
    const auto is_in_the_way = [&](const FlatRing& other) { return blocks(other, from, to); };
    if (!is_in_the_way(ring) && std::none_of(others.begin(), others.end(), is_in_the_way)) return ends;
  }
  return bridges.front().second;
}

/// The ring goes over the bridge, around the hole and back. Where the two touch, the bridge has no length.
void join(FlatRing& ring, const FlatRing& hole, const std::pair<std::size_t, std::size_t>& ends) {
  FlatRing joined;
  const auto add = [&](const FlatRing& from, std::size_t i) {
    i %= from.corners.size();
    if (!joined.points.empty() && joined.points.back() == from.points[i]) return;
    joined.corners.push_back(from.corners[i]);
    joined.points.push_back(from.points[i]);
  };
  for (std::size_t i = 0; i <= ends.first; ++i) add(ring, i);
  for (std::size_t k = 0; k <= hole.corners.size(); ++k) add(hole, ends.second + k);
  for (std::size_t i = ends.first; i < ring.corners.size(); ++i) add(ring, i);
  ring = std::move(joined);
}

/// n lies between the sides of a triangle at its corner p, whose next corner is q and the one before r.
bool is_between(const Point& p, const Point& q, const Point& r, const Point& n) {
  return cross(p, q, n) > 0 && cross(p, r, n) < 0;
}

bool is_ear(const std::vector<Point>& points, const std::vector<std::size_t>& rest, std::size_t at) {
  const std::size_t count = rest.size();
  const std::size_t before = (at + count - 1) % count;
  const std::size_t after = (at + 1) % count;
  const Point &a = points[rest[before]], &b = points[rest[at]], &c = points[rest[after]];
  if (!(cross(a, b, c) > 0)) return false;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == before || i == at || i == after) continue;
    const Point& p = points[rest[i]];
    // The polygon may come by again at one of the three corners; what counts is whether it enters the ear there.
    const auto enters = [&](const Point& q, const Point& r) {
      return is_between(p, q, r, points[rest[(i + 1) % count]]) ||
             is_between(p, q, r, points[rest[(i + count - 1) % count]]);
    };
    const bool is_blocked = p == a   ? enters(b, c)
                            : p == b ? enters(c, a)
                            : p == c ? enters(a, b)
                                     : cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
    if (is_blocked) return false;
  }
  return true;
}

/// Nothing lies between a corner's neighbours and itself: where a polygon touches itself, what is left of a part that
/// was cut away.
bool is_spent(const std::vector<Point>& points, const std::vector<std::size_t>& rest, std::size_t at) {
  const Point& before = points[rest[(at + rest.size() - 1) % rest.size()]];
  const Point& after = points[rest[(at + 1) % rest.size()]];
  return before == after || before == points[rest[at]];
}

void cut_ears(std::span<const std::uint32_t> corners, const std::vector<Point>& points,
              std::vector<Triangle>& triangles) {
  std::vector<std::size_t> rest(corners.size());
  for (std::size_t i = 0; i < rest.size(); ++i) rest[i] = i;
  const auto first_that = [&](auto is_wanted) {
    std::size_t at = 0;
    while (at < rest.size() && !is_wanted(points, rest, at)) ++at;
    return at;
  };
  while (rest.size() >= 3) {
    std::size_t at = first_that(is_spent);
    if (at == rest.size()) {
      at = first_that(is_ear);
      // A polygon that crosses itself may have none left; what remains is still covered.
      if (at == rest.size()) at = 0;
      const std::size_t before = (at + rest.size() - 1) % rest.size();
      triangles.push_back({corners[rest[before]], corners[rest[at]], corners[rest[(at + 1) % rest.size()]]});
    }
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(at));
  }
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
  cut_ears(corners, flattened(corners, positions), triangles);
  return true;
}

void append_flat_polygon(std::vector<FlatRing> rings, std::vector<Triangle>& triangles) {
  // From right to left, as in Eberly, "Triangulation by ear clipping": a bridge then finds the ones before in place.
  const auto rightmost = [](const FlatRing& ring) {
    return std::max_element(ring.points.begin(), ring.points.end(),
                            [](const Point& a, const Point& b) { return a.x() < b.x(); })
        ->x();
  };
  std::sort(rings.begin() + 1, rings.end(),
            [&](const FlatRing& a, const FlatRing& b) { return rightmost(a) > rightmost(b); });
  FlatRing outer = rings.front();
  for (std::size_t i = 1; i < rings.size(); ++i) {
    join(outer, rings[i], bridge(outer, rings[i], std::span{rings}.subspan(i)));
  }
  cut_ears(outer.corners, outer.points, triangles);
}

}  // namespace meshloop
