#include "server/adjust/part.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/connected.h"
#include "server/adjust/places.h"

namespace meshloop::adjust {
namespace {

constexpr std::size_t kPoints = 2400;
/// Normals count as one direction from here on, and as square to another up to there.
constexpr double kSameDirection = 0.985;
constexpr double kSquare = 0.1;

/// Length: twice the area.
Eigen::Vector3d area_normal(const Submesh& submesh, const Triangle& triangle) {
  const Eigen::Vector3d a = submesh.positions[triangle[0]].cast<double>();
  const Eigen::Vector3d b = submesh.positions[triangle[1]].cast<double>();
  const Eigen::Vector3d c = submesh.positions[triangle[2]].cast<double>();
  return (b - a).cross(c - a);
}

// The k-th point of a triangle: the additive sequence of the plastic number (Roberts 2018), folded into the triangle.
Eigen::Vector3d spread_point(const Submesh& submesh, const Triangle& triangle, std::size_t k) {
  double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(k), 1.0);
  double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(k), 1.0);
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  const Eigen::Vector3d a = submesh.positions[triangle[0]].cast<double>();
  const Eigen::Vector3d b = submesh.positions[triangle[1]].cast<double>();
  const Eigen::Vector3d c = submesh.positions[triangle[2]].cast<double>();
  return a + u * (b - a) + v * (c - a);
}

std::vector<SurfacePoint> spread_points(const Submesh& submesh) {
  double total = 0;
  for (const auto& triangle : submesh.triangles) total += area_normal(submesh, triangle).norm();
  std::vector<SurfacePoint> in_order;
  double due = 0;
  for (const auto& triangle : submesh.triangles) {
    const Eigen::Vector3d normal = area_normal(submesh, triangle);
    due += normal.norm() / total * static_cast<double>(kPoints);
    for (; due >= 1; due -= 1) {
      in_order.push_back({spread_point(submesh, triangle, in_order.size()), normal.normalized()});
    }
  }
  // A step that shares no divisor with their number visits all of them, far apart from one to the next.
  std::vector<SurfacePoint> points;
  points.reserve(in_order.size());
  std::size_t step = in_order.size() * 618 / 1000 + 1;
  while (std::gcd(step, in_order.size()) > 1) ++step;
  for (std::size_t i = 0, at = 0; i < in_order.size(); ++i, at = (at + step) % in_order.size()) {
    points.push_back(in_order[at]);
  }
  return points;
}

/// The direction in which most of the surface faces, either way, of those square to `other` (zero: of all).
Eigen::Vector3d main_direction(const std::vector<SurfacePoint>& points, const Eigen::Vector3d& other) {
  constexpr std::size_t kTried = 60;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double most = 0;
  for (std::size_t i = 0; i < std::min(kTried, points.size()); ++i) {
    const Eigen::Vector3d& tried = points[i].normal;
    if (std::abs(tried.dot(other)) > kSquare) continue;
    double count = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& point : points) {
      const double along = tried.dot(point.normal);
      if (std::abs(along) < kSameDirection) continue;
      count += 1;
      sum += along > 0 ? point.normal : Eigen::Vector3d(-point.normal);
    }
    if (count <= most) continue;
    most = count;
    best = sum.normalized();
  }
  return best;
}

Eigen::Matrix3d main_axes(const std::vector<SurfacePoint>& points) {
  const Eigen::Vector3d first = main_direction(points, Eigen::Vector3d::Zero());
  if (first.isZero()) return Eigen::Matrix3d::Identity();
  Eigen::Vector3d second = main_direction(points, first);
  if (second.isZero()) second = first.unitOrthogonal();
  second = (second - first.dot(second) * first).normalized();
  Eigen::Matrix3d axes;
  axes << first, second, first.cross(second);
  return axes;
}

}  // namespace

PartNumbers number_parts(const Submesh& submesh) {
  const auto places = places_of(submesh.positions);
  Connected connected{places.size()};
  for (const auto& [a, b, c] : submesh.triangles) {
    connected.join(places[a], places[b]);
    connected.join(places[b], places[c]);
  }
  PartNumbers numbers;
  std::vector<std::uint32_t> number_of_first(places.size(), submesh.triangles.empty() ? 0 : ~0U);
  numbers.of_triangle.reserve(submesh.triangles.size());
  for (const auto& triangle : submesh.triangles) {
    auto& number = number_of_first[connected.first_of(places[triangle[0]])];
    if (number == ~0U) number = numbers.count++;
    numbers.of_triangle.push_back(number);
  }
  return numbers;
}

Part make_part(const Node& node, std::size_t node_position, std::vector<bool> triangles) {
  Part part;
  part.node_position = node_position;
  part.is_whole_node = std::find(triangles.begin(), triangles.end(), false) == triangles.end();
  part.submesh = part.is_whole_node ? *node.submesh : keep_triangles(*node.submesh, triangles);
  part.triangles = std::move(triangles);
  part.counted.resize(part.submesh.triangles.size());
  std::iota(part.counted.begin(), part.counted.end(), 0U);
  part.points = spread_points(part.submesh);
  part.axes = main_axes(part.points);
  Eigen::AlignedBox3d box;
  for (const auto& p : part.submesh.positions) box.extend(part.axes.transpose() * p.cast<double>());
  part.center = part.axes * box.center();
  part.radius_m = box.diagonal().norm() / 2;
  return part;
}

}  // namespace meshloop::adjust
