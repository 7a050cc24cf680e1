#include "common/detail/working_cluster.h"

#include <algorithm>

namespace meshloop {

Sphere bounding_sphere(const std::vector<Eigen::Vector3f>& positions, const std::vector<Triangle>& triangles) {
  Eigen::AlignedBox3f box;
  for (const auto& triangle : triangles) {
    for (const auto vertex : triangle) box.extend(positions[vertex]);
  }
  if (box.isEmpty()) return {};
  Sphere sphere{box.center(), 0};
  float square = 0;
  for (const auto& triangle : triangles) {
    for (const auto vertex : triangle) square = std::max(square, (positions[vertex] - sphere.center).squaredNorm());
  }
  // Rounded up: a sphere must never be too small.
  constexpr float kRoundUp = 1.000001f;
  sphere.radius = std::sqrt(square) * kRoundUp;
  return sphere;
}

Sphere joined(const Sphere& a, const Sphere& b) {
  const Eigen::Vector3f step = b.center - a.center;
  const float distance = step.norm();
  if (distance + b.radius <= a.radius) return a;
  if (distance + a.radius <= b.radius) return b;
  constexpr float kRoundUp = 1.000001f;
  const float radius = 0.5f * (distance + a.radius + b.radius);
  return {a.center + step * ((radius - a.radius) / distance), radius * kRoundUp};
}

}  // namespace meshloop
