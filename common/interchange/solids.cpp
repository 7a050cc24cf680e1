#include "common/interchange/solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/interchange/scene_geometry.h"

namespace meshloop {
namespace {

/// Segments of a full turn whose chords stay within the deflection: r (1 - cos(pi / n)).
std::uint32_t segments_of(double radius, double deflection = kSolidDeflection) {
  constexpr double kFewest = 16, kMost = 512;
  const double half_angle = std::acos(std::max(0.0, 1 - deflection / radius));
  return static_cast<std::uint32_t>(std::clamp(std::ceil(std::numbers::pi / half_angle), kFewest, kMost));
}

/// A point of the outline that turns about the y axis.
struct Ring {
  double radius;
  double height;
};

/// Rings from the top down, joined by triangles; rings of radius 0 are single points.
Submesh turned(const std::vector<Ring>& rings, std::uint32_t segments) {
  Submesh mesh;
  const auto point = [&](const Ring& ring, std::uint32_t k) {
    const double angle = 2 * std::numbers::pi * (k % segments) / segments;
    mesh.positions.emplace_back(
        Eigen::Vector3d{ring.radius * std::sin(angle), ring.height, ring.radius * std::cos(angle)}.cast<float>());
    return static_cast<std::uint32_t>(mesh.positions.size() - 1);
  };
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    const Ring &upper = rings[r], &lower = rings[r + 1];
    for (std::uint32_t k = 0; k < segments; ++k) {
      if (lower.radius > 0) mesh.triangles.push_back({point(upper, k), point(lower, k), point(lower, k + 1)});
      if (upper.radius > 0) mesh.triangles.push_back({point(upper, k), point(lower, k + 1), point(upper, k + 1)});
    }
  }
  return mesh;
}

void append(const Submesh& piece, Submesh& mesh) {
  const auto shift = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), piece.positions.begin(), piece.positions.end());
  for (const auto& [a, b, c] : piece.triangles) mesh.triangles.push_back({a + shift, b + shift, c + shift});
}

Result<Submesh> box(const WebNode& node) {
  const auto size = node.numbers("size", {2, 2, 2});
  if (size.size() != 3 || !(*std::min_element(size.begin(), size.end()) > 0)) return fail("a Box has no size");
  Submesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.emplace_back(
        Eigen::Vector3d{(i & 1 ? 0.5 : -0.5) * size[0], (i & 2 ? 0.5 : -0.5) * size[1], (i & 4 ? 0.5 : -0.5) * size[2]}
            .cast<float>());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Result<Submesh> sphere(const WebNode& node) {
  const double radius = node.number("radius", 1);
  if (!(radius > 0)) return fail("a Sphere has no radius");
  // It bends in two directions, whose deflections add up.
  const std::uint32_t segments = segments_of(radius, kSolidDeflection / 2);
  const std::uint32_t rows = segments / 2;
  std::vector<Ring> rings;
  for (std::uint32_t i = 0; i <= rows; ++i) {
    const double angle = std::numbers::pi * i / rows;
    const bool pole = i == 0 || i == rows;
    rings.push_back({pole ? 0 : radius * std::sin(angle), radius * std::cos(angle)});
  }
  return turned(rings, segments);
}

Result<Submesh> cylinder(const WebNode& node) {
  const double radius = node.number("radius", 1), half = node.number("height", 2) / 2;
  if (!(radius > 0 && half > 0)) return fail("a Cylinder has no radius or no height");
  const bool top = node.flag("top", true), side = node.flag("side", true), bottom = node.flag("bottom", true);
  Submesh mesh;
  if (top) append(turned({{0, half}, {radius, half}}, segments_of(radius)), mesh);
  if (side) append(turned({{radius, half}, {radius, -half}}, segments_of(radius)), mesh);
  if (bottom) append(turned({{radius, -half}, {0, -half}}, segments_of(radius)), mesh);
  return mesh;
}

Result<Submesh> cone(const WebNode& node) {
  const double radius = node.number("bottomRadius", 1), half = node.number("height", 2) / 2;
  if (!(radius > 0 && half > 0)) return fail("a Cone has no radius or no height");
  std::vector<Ring> rings;
  if (node.flag("side", true)) rings.push_back({0, half});
  rings.push_back({radius, -half});
  if (node.flag("bottom", true)) rings.push_back({0, -half});
  return turned(rings, segments_of(radius));
}

}  // namespace

Result<Submesh> tessellate_solid(const WebNode& node) {
  if (node.type == "Box") return box(node);
  if (node.type == "Sphere") return sphere(node);
  if (node.type == "Cylinder") return cylinder(node);
  if (node.type == "Cone") return cone(node);
  return fail(fmt::format("'{}' is no solid", node.type));
}

}  // namespace meshloop
