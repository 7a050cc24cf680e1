#include "server/adjust/flip_edges.h"

#include <Eigen/LU>
#include <array>
#include <map>

namespace meshloop::adjust {
namespace {

using Point = Eigen::Vector2d;

/// Twice the area, positive for front faces.
double area2(const Point& a, const Point& b, const Point& c) {
  return (b - a).y() * (c - a).x() - (b - a).x() * (c - a).y();
}

/// p lies inside the circle through a, b and c, by more than rounding.
bool in_circle(const Point& a, const Point& b, const Point& c, const Point& p) {
  Eigen::Matrix3d m;
  for (int row = 0; row < 3; ++row) {
    const Point d = (row == 0 ? a : row == 1 ? b : c) - p;
    m.row(row) << d.x(), d.y(), d.squaredNorm();
  }
  return -m.determinant() > 1e-9;  // v points down
}

class Flipper {
 public:
  Flipper(std::vector<Triangle>& triangles, const std::function<Eigen::Vector2f(std::uint32_t)>& place)
      : triangles_{triangles} {
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        triangle_of_edge_[{triangles[t][k], triangles[t][(k + 1) % 3]}] = t;
        points_[triangles[t][k]] = place(triangles[t][k]).cast<double>();
      }
    }
  }

  void run() {
    // Each flip makes the triangulation better by a measure that cannot grow for ever; the limit is for rounding.
    std::size_t left = 10 * triangles_.size() * triangles_.size() + 100;
    for (bool again = true; again && left > 0;) {
      again = false;
      for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
        for (std::size_t k = 0; k < 3 && left > 0; ++k, --left) again = flip(t, k) || again;
      }
    }
  }

 private:
  bool flip(std::uint32_t t, std::size_t k) {
    const auto a = triangles_[t][k];
    const auto b = triangles_[t][(k + 1) % 3];
    const auto c = triangles_[t][(k + 2) % 3];
    const auto other = triangle_of_edge_.find({b, a});
    if (other == triangle_of_edge_.end()) return false;
    const auto u = other->second;
    std::uint32_t d = c;
    for (const auto i : triangles_[u]) {
      if (i != a && i != b) d = i;
    }
    if (d == c || triangle_of_edge_.contains({c, d}) || triangle_of_edge_.contains({d, c})) return false;
    const Point &pa = points_[a], &pb = points_[b], &pc = points_[c], &pd = points_[d];
    const double least = 1e-6;
    if (!(area2(pc, pa, pd) > least && area2(pd, pb, pc) > least) || !in_circle(pa, pb, pc, pd)) return false;
    triangle_of_edge_.erase({a, b});
    triangle_of_edge_.erase({b, a});
    set(t, {c, a, d});
    set(u, {d, b, c});
    return true;
  }

  void set(std::uint32_t t, const Triangle& triangle) {
    triangles_[t] = triangle;
    for (std::size_t k = 0; k < 3; ++k) triangle_of_edge_[{triangle[k], triangle[(k + 1) % 3]}] = t;
  }

  std::vector<Triangle>& triangles_;
  std::map<std::uint32_t, Point> points_;
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> triangle_of_edge_;
};

}  // namespace

void flip_to_delaunay(std::vector<Triangle>& triangles, const std::function<Eigen::Vector2f(std::uint32_t)>& place) {
  Flipper{triangles, place}.run();
}

}  // namespace meshloop::adjust
