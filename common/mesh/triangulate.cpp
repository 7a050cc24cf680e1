#include "common/mesh/triangulate.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
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

/// A way from a ring's corner towards `to` begins inside the ring. A corner may stand in the ring more than once, and
/// this is true of one of them.
bool begins_inside(const FlatRing& ring, std::size_t i, const Point& to) {
  const std::size_t count = ring.points.size();
  const Point& before = ring.points[(i + count - 1) % count];
  const Point& here = ring.points[i];
  const Point& after = ring.points[(i + 1) % count];
  const bool left_of_last = cross(before, here, to) > 0;
  const bool left_of_next = cross(here, after, to) > 0;
  return cross(before, here, after) > 0 ? left_of_last && left_of_next : left_of_last || left_of_next;
}

/// At corners of the ring that lie at one end of a way, the way does not run through what the ring leaves out.
bool lets_by(const FlatRing& ring, const Point& end, const Point& other_end) {
  for (std::size_t i = 0; i < ring.points.size(); ++i) {
    if (ring.points[i] == end && !begins_inside(ring, i, other_end)) return false;
  }
  return true;
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
    // Where the two touch, the hole's own line shows the way.
    const Point& way = from == to ? hole.points[(ends.second + 1) % hole.points.size()] : to;
    if (!begins_inside(ring, ends.first, way)) continue;
    const auto is_in_the_way = [&](const FlatRing& other) {
      return from != to && (blocks(other, from, to) || !lets_by(other, from, to) || !lets_by(other, to, from));
    };
    if (!blocks(ring, from, to) && std::none_of(others.begin(), others.end(), is_in_the_way)) return ends;
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

/// Cuts ears off one ring. It goes on where the last one was, so that a ring without narrow places costs the square of
/// its corners.
class EarCutter {
 public:
  EarCutter(std::span<const std::uint32_t> corners, const std::vector<Point>& points, std::vector<Triangle>& triangles)
      : corners_{corners}, points_{points}, triangles_{triangles}, rest_(corners.size()) {
    std::iota(rest_.begin(), rest_.end(), std::size_t{0});
  }

  void run() {
    for (std::size_t at = 0; rest_.size() >= 3 && at < rest_.size();) {
      at = is_spent(at) ? take(at) : at + 1;
    }
    std::size_t at = 0;
    std::size_t passed = 0;
    while (rest_.size() >= 3) {
      at %= rest_.size();
      // A polygon that crosses itself may have no ear left; what remains is still covered.
      if (passed < rest_.size() && !is_ear(points_, rest_, at)) {
        ++at;
        ++passed;
        continue;
      }
      triangles_.push_back({corner(before(at)), corner(at), corner(after(at))});
      at = take(at);
      passed = 0;
    }
  }

 private:
  [[nodiscard]] std::size_t before(std::size_t at) const { return (at + rest_.size() - 1) % rest_.size(); }
  [[nodiscard]] std::size_t after(std::size_t at) const { return (at + 1) % rest_.size(); }
  [[nodiscard]] std::uint32_t corner(std::size_t at) const { return corners_[rest_[at]]; }
  [[nodiscard]] const Point& point(std::size_t at) const { return points_[rest_[at]]; }

  /// Nothing lies between a corner's neighbours and itself: where a polygon touches itself, what is left of a part that
  /// was cut away.
  [[nodiscard]] bool is_spent(std::size_t at) const {
    return point(before(at)) == point(after(at)) || point(before(at)) == point(at);
  }

  /// Takes a corner out, and those beside it that are spent by that; where to go on.
  std::size_t take(std::size_t at) {
    for (;;) {
      rest_.erase(rest_.begin() + static_cast<std::ptrdiff_t>(at));
      if (rest_.size() < 3) return 0;
      at %= rest_.size();
      if (is_spent(at)) continue;
      if (!is_spent(before(at))) return at;
      at = before(at);
    }
  }

  std::span<const std::uint32_t> corners_;
  const std::vector<Point>& points_;
  std::vector<Triangle>& triangles_;
  /// Positions in the ring that are not cut off yet.
  std::vector<std::size_t> rest_;
};

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
  EarCutter{corners, points, triangles}.run();
  return true;
}

void append_flat_polygon(std::vector<FlatRing> rings, std::vector<Triangle>& triangles) {
  // Bridges as in Eberly, "Triangulation by ear clipping", but the shortest ones.
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
  EarCutter{outer.corners, outer.points, triangles}.run();
}

}  // namespace meshloop
