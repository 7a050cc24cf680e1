#include "common/detail/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace meshloop {
namespace {

/// For each vertex the triangles at it, or the vertices beside it.
class Incidence {
 public:
  Incidence(std::size_t vertices, const std::vector<Triangle>& triangles) : first_(vertices + 1, 0) {
    for (const auto& triangle : triangles) {
      for (const auto vertex : triangle) ++first_[vertex + 1];
    }
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    entries_.resize(3 * triangles.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      for (const auto vertex : triangles[t]) entries_[next[vertex]++] = t;
    }
  }
  [[nodiscard]] std::span<const std::uint32_t> at(std::uint32_t vertex) const {
    return std::span{entries_}.subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> entries_;
};

/// Over the area, of what is given at the vertices and linear between them: in a triangle the mean square is a sixth of
/// the sum of all squares and products of two.
float root_mean_square(const LocalMesh& part, const std::vector<float>& at_vertices) {
  double sum = 0;
  double area = 0;
  for (const auto& triangle : part.triangles) {
    const float a = at_vertices[triangle[0]];
    const float b = at_vertices[triangle[1]];
    const float c = at_vertices[triangle[2]];
    const auto weight = static_cast<double>(normal_of(part.positions, triangle).norm());
    sum += weight * static_cast<double>(a * a + b * b + c * c + a * b + b * c + c * a) / 6;
    area += weight;
  }
  return area > 0 ? static_cast<float>(std::sqrt(sum / area)) : 0;
}

/// Looks from a vertex that was left out over the old triangles, ring by ring, for those that stayed, and measures to
/// the new triangles there. A distance that would be the largest so far is made sure of: all new triangles are asked.
class DeviationSearch {
 public:
  DeviationSearch(const LocalMesh& before, const std::vector<Triangle>& after)
      : before_{before},
        after_{after},
        old_triangles_{before.vertices.size(), before.triangles},
        new_triangles_{before.vertices.size(), after},
        seen_(before.vertices.size(), 0) {}

  Deviation measure() {
    float largest_square = 0;
    std::vector<float> distances_m(before_.vertices.size(), 0);
    for (std::uint32_t vertex = 0; vertex < distances_m.size(); ++vertex) {
      if (!new_triangles_.at(vertex).empty()) continue;
      float square = nearby(vertex);
      if (square > largest_square) square = to_all(vertex);
      largest_square = std::max(largest_square, square);
      distances_m[vertex] = std::sqrt(square);
    }
    return {std::sqrt(largest_square), root_mean_square(before_, distances_m)};
  }

 private:
  /// Squared distance to the new triangles at the nearest ring that has some; infinite when none has.
  float nearby(std::uint32_t vertex) {
    float square = std::numeric_limits<float>::infinity();
    ++round_;
    seen_[vertex] = round_;
    std::vector<std::uint32_t>& ring = ring_;
    ring.assign(1, vertex);
    while (!ring.empty() && !std::isfinite(square)) {
      grow(ring);
      for (const auto other : ring) square = std::min(square, distance(vertex, other));
    }
    return square;
  }

  void grow(std::vector<std::uint32_t>& ring) {
    next_.clear();
    for (const auto vertex : ring) {
      for (const auto triangle : old_triangles_.at(vertex)) {
        for (const auto other : before_.triangles[triangle]) {
          if (seen_[other] == round_) continue;
          seen_[other] = round_;
          next_.push_back(other);
        }
      }
    }
    ring.swap(next_);
  }

  [[nodiscard]] float distance(std::uint32_t vertex, std::uint32_t kept) const {
    float square = std::numeric_limits<float>::infinity();
    for (const auto triangle : new_triangles_.at(kept))
      square = std::min(square, to_triangle(vertex, after_[triangle]));
    return square;
  }
  [[nodiscard]] float to_all(std::uint32_t vertex) const {
    float square = std::numeric_limits<float>::infinity();
    for (const auto& triangle : after_) square = std::min(square, to_triangle(vertex, triangle));
    return square;
  }
  [[nodiscard]] float to_triangle(std::uint32_t vertex, const Triangle& triangle) const {
    const auto& p = before_.positions;
    return squared_distance(p[vertex], p[triangle[0]], p[triangle[1]], p[triangle[2]]);
  }

  const LocalMesh& before_;
  const std::vector<Triangle>& after_;
  Incidence old_triangles_;
  Incidence new_triangles_;
  std::vector<std::uint32_t> seen_;
  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> ring_;
  std::vector<std::uint32_t> next_;
};

/// Weighted with the triangles' areas, of no particular length.
std::vector<Eigen::Vector3f> vertex_normals(const LocalMesh& part) {
  std::vector<Eigen::Vector3f> normals(part.positions.size(), Eigen::Vector3f::Zero());
  for (const auto& triangle : part.triangles) {
    const Eigen::Vector3f normal = normal_of(part.positions, triangle);
    for (const auto vertex : triangle) normals[vertex] += normal;
  }
  return normals;
}

/// Some triangle faces against the old surface at its corners.
bool is_folded(const LocalMesh& part, const std::vector<Eigen::Vector3f>& old_normals,
               const std::vector<Triangle>& triangles) {
  return std::any_of(triangles.begin(), triangles.end(), [&](const Triangle& triangle) {
    const auto& [a, b, c] = triangle;
    return normal_of(part.positions, triangle).dot(old_normals[a] + old_normals[b] + old_normals[c]) < 0;
  });
}

struct Collapsed {
  std::vector<Triangle> triangles;
  /// meshoptimizer's own estimate, relative to the part's size.
  float error = 0;
};

Collapsed collapse(const LocalMesh& part, double share) {
  // In effect without a limit: the error is judged afterwards.
  constexpr float kAnyError = 1;
  Collapsed result;
  result.triangles.resize(part.triangles.size());
  const auto target = static_cast<std::size_t>(share * static_cast<double>(part.triangles.size()));
  const std::size_t kept =
      meshopt_simplify(result.triangles.front().data(), part.triangles.front().data(), 3 * part.triangles.size(),
                       part.positions.front().data(), part.positions.size(), sizeof(Eigen::Vector3f), 3 * target,
                       kAnyError, meshopt_SimplifyLockBorder, &result.error);
  result.triangles.resize(kept / 3);
  return result;
}

float square_to_segment(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f edge = b - a;
  const float length = edge.squaredNorm();
  const float along = length > 0 ? std::clamp((p - a).dot(edge) / length, 0.0f, 1.0f) : 0.0f;
  return (p - a - along * edge).squaredNorm();
}

}  // namespace

Eigen::Vector3f normal_of(const std::vector<Eigen::Vector3f>& positions, const Triangle& triangle) {
  const auto& a = positions[triangle[0]];
  return (positions[triangle[1]] - a).cross(positions[triangle[2]] - a);
}

float squared_distance(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                       const Eigen::Vector3f& c) {
  const Eigen::Vector3f normal = (b - a).cross(c - a);
  const bool inside = normal.dot((b - a).cross(p - a)) >= 0 && normal.dot((c - b).cross(p - b)) >= 0 &&
                      normal.dot((a - c).cross(p - c)) >= 0;
  const float length = normal.squaredNorm();
  if (inside && length > 0) {
    const float height = normal.dot(p - a);
    return height * height / length;
  }
  return std::min({square_to_segment(p, a, b), square_to_segment(p, b, c), square_to_segment(p, c, a)});
}

Simplified simplify_to_half(const LocalMesh& part) {
  // With its border held, a part may have no good way to a half: the last collapses then cost many times what those
  // before did, or fold the surface over itself. Fewer collapses are taken then.
  constexpr std::array kShares{0.5, 0.6, 0.7, 0.8};
  constexpr float kCliff = 3;
  const auto normals = vertex_normals(part);
  Collapsed chosen = collapse(part, kShares.front());
  for (std::size_t i = 1; i < kShares.size(); ++i) {
    Collapsed gentler = collapse(part, kShares[i]);
    if (chosen.error <= kCliff * gentler.error && !is_folded(part, normals, chosen.triangles)) break;
    chosen = std::move(gentler);
  }
  Simplified result;
  result.triangles = std::move(chosen.triangles);
  if (!result.triangles.empty()) result.deviation = DeviationSearch{part, result.triangles}.measure();
  return result;
}

}  // namespace meshloop
