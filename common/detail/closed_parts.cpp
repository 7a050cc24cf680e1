#include "common/detail/closed_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "common/detail/working_cluster.h"

namespace meshloop {
namespace {

/// A triangle's side. The vertices in ascending order.
struct Side {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  bool is_upwards = false;

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> edge() const { return {low, high}; }
};

/// By edge.
std::vector<Side> sides_of(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = triangles[t][k];
      const std::uint32_t to = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge() < b.edge(); });
  return sides;
}

/// Triangles that hang together, by the first of them.
class Connected {
 public:
  explicit Connected(std::size_t triangles) : parent_(triangles) { std::iota(parent_.begin(), parent_.end(), 0U); }

  void join(std::uint32_t a, std::uint32_t b) {
    a = first_of(a);
    b = first_of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::uint32_t first_of(std::uint32_t triangle) {
    while (parent_[triangle] != triangle) {
      parent_[triangle] = parent_[parent_[triangle]];
      triangle = parent_[triangle];
    }
    return triangle;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// By triangle: the number of its part, or kNone where the part has a border.
struct Parts {
  std::vector<std::int32_t> of_triangle;
  std::int32_t count = 0;
};

Parts without_border(std::span<const Triangle> triangles) {
  const std::vector<Side> sides = sides_of(triangles);
  Connected connected{triangles.size()};
  std::vector<std::uint32_t> at_border;
  for (std::size_t first = 0; first < sides.size();) {
    int surplus = 0;
    std::size_t last = first;
    for (; last < sides.size() && sides[last].edge() == sides[first].edge(); ++last) {
      surplus += sides[last].is_upwards ? 1 : -1;
      connected.join(sides[first].triangle, sides[last].triangle);
    }
    if (surplus != 0) at_border.push_back(sides[first].triangle);
    first = last;
  }
  std::vector<bool> is_open(triangles.size(), false);
  for (const auto triangle : at_border) is_open[connected.first_of(triangle)] = true;
  Parts parts;
  parts.of_triangle.assign(triangles.size(), ClosedParts::kNone);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const std::uint32_t first = connected.first_of(t);
    if (is_open[first]) continue;
    parts.of_triangle[t] = first == t ? parts.count++ : parts.of_triangle[first];
  }
  return parts;
}

constexpr std::size_t kDirections = 32;

/// Evenly over the sphere: along a spiral of golden angles.
std::array<Eigen::Vector3f, kDirections> all_around() {
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  std::array<Eigen::Vector3f, kDirections> directions;
  for (std::size_t i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(kDirections);
    const double r = std::sqrt(1 - z * z);
    const double angle = golden * static_cast<double>(i);
    directions[i] = Eigen::Vector3d{r * std::cos(angle), r * std::sin(angle), z}.cast<float>();
  }
  return directions;
}

/// The normal of a triangle's corner, as long as its angle.
Eigen::Vector3d weighted_normal(const std::vector<Eigen::Vector3f>& positions, const Triangle& triangle,
                                std::size_t corner) {
  const Eigen::Vector3d p = positions[triangle[corner]].cast<double>();
  const Eigen::Vector3d to_next = positions[triangle[(corner + 1) % 3]].cast<double>() - p;
  const Eigen::Vector3d to_last = positions[triangle[(corner + 2) % 3]].cast<double>() - p;
  const Eigen::Vector3d normal = to_next.cross(to_last);
  const double length = normal.norm();
  if (!(length > 0)) return Eigen::Vector3d::Zero();
  return normal * (std::atan2(length, to_next.dot(to_last)) / length);
}

bool faces_outwards(const std::vector<Eigen::Vector3f>& positions, const std::vector<Triangle>& part) {
  static const auto kAllAround = all_around();
  std::array<std::uint32_t, kDirections> outermost;
  outermost.fill(part.front().front());
  for (const auto& triangle : part) {
    for (const auto vertex : triangle) {
      for (std::size_t i = 0; i < kDirections; ++i) {
        const Eigen::Vector3f beyond = positions[vertex] - positions[outermost[i]];
        if (beyond.dot(kAllAround[i]) > 0) outermost[i] = vertex;
      }
    }
  }
  std::map<std::uint32_t, Eigen::Vector3d> normals;
  for (const auto vertex : outermost) normals.emplace(vertex, Eigen::Vector3d::Zero());
  for (const auto& triangle : part) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto normal = normals.find(triangle[k]);
      if (normal != normals.end()) normal->second += weighted_normal(positions, triangle, k);
    }
  }
  for (std::size_t i = 0; i < kDirections; ++i) {
    if (!(normals.at(outermost[i]).dot(kAllAround[i].cast<double>()) > 0)) return false;
  }
  return true;
}

}  // namespace

ClosedParts closed_parts_of(const std::vector<Eigen::Vector3f>& positions, std::span<const Triangle> triangles) {
  const Parts parts = without_border(triangles);
  std::vector<std::vector<Triangle>> closed(static_cast<std::size_t>(parts.count));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (parts.of_triangle[t] != ClosedParts::kNone) {
      closed[static_cast<std::size_t>(parts.of_triangle[t])].push_back(triangles[t]);
    }
  }
  ClosedParts result;
  std::vector<std::int32_t> number(closed.size(), ClosedParts::kNone);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (!faces_outwards(positions, closed[i])) continue;
    number[i] = static_cast<std::int32_t>(result.bounds.size());
    result.bounds.push_back(bounds_of(positions, closed[i]));
  }
  constexpr std::int32_t kUnknown = -2;
  result.of_vertex.assign(positions.size(), kUnknown);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::int32_t part = parts.of_triangle[t];
    const std::int32_t own = part == ClosedParts::kNone ? part : number[static_cast<std::size_t>(part)];
    for (const auto vertex : triangles[t]) {
      auto& known = result.of_vertex[vertex];
      known = known == kUnknown || known == own ? own : ClosedParts::kNone;
    }
  }
  return result;
}

}  // namespace meshloop
