#include "server/adjust/depth_buffer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace meshloop::adjust {
namespace {

constexpr double kNearest_m = 0.05;

/// A corner in the picture, with one divided by its depth: linear across a triangle.
struct Corner {
  double x;
  double y;
  double q;
};

Corner project(const Camera& camera, const Eigen::Vector3d& p) {
  return {camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy, 1 / p.z()};
}

double twice_area(const Corner& a, const Corner& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// Columns, both included; none when `from` > `to`.
struct Span {
  int from;
  int to;
};

// Pixels of row y whose centres lie in the triangle (its corners run so that inside is positive).
Span span_of(const std::array<Corner, 3>& corners, int y, int x0, int x1) {
  double from = x0;
  double to = x1 - 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Corner& a = corners[i];
    const Corner& b = corners[(i + 1) % 3];
    // a linear function of x: value at 0, and slope
    const double slope = -(b.y - a.y);
    const double start = twice_area(a, b, 0, y);
    if (slope > 0) {
      from = std::max(from, -start / slope);
    } else if (slope < 0) {
      to = std::min(to, -start / slope);
    } else if (start < 0) {
      return {1, 0};
    }
  }
  if (!(from <= to)) return {1, 0};
  constexpr double kOnTheEdge = 1e-9;
  return {static_cast<int>(std::ceil(from - kOnTheEdge)), static_cast<int>(std::floor(to + kOnTheEdge))};
}

void fill(std::array<Corner, 3> corners, std::uint32_t what, DepthBuffer& buffer) {
  double area = twice_area(corners[0], corners[1], corners[2].x, corners[2].y);
  if (area < 0) {
    std::swap(corners[1], corners[2]);
    area = -area;
  }
  if (!(area > 0)) return;
  const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  const Window& window = buffer.window;
  const auto x0 = static_cast<int>(std::ceil(std::max<double>(left, window.x0)));
  const auto x1 = static_cast<int>(std::floor(std::min<double>(right, window.x1 - 1))) + 1;
  const auto y0 = static_cast<int>(std::ceil(std::max<double>(top, window.y0)));
  const auto y1 = static_cast<int>(std::floor(std::min<double>(bottom, window.y1 - 1))) + 1;
  if (x0 >= x1 || y0 >= y1) return;
  const auto& [a, b, c] = corners;
  const double q_per_x = ((b.q - a.q) * (c.y - a.y) - (c.q - a.q) * (b.y - a.y)) / area;
  const double q_per_y = ((c.q - a.q) * (b.x - a.x) - (b.q - a.q) * (c.x - a.x)) / area;
  for (int y = y0; y < y1; ++y) {
    const Span span = span_of(corners, y, x0, x1);
    double q = a.q + q_per_x * (span.from - a.x) + q_per_y * (y - a.y);
    std::size_t i = buffer.at(span.from, y);
    for (int x = span.from; x <= span.to; ++x, ++i, q += q_per_x) {
      const auto z = static_cast<float>(1 / q);
      if (!(q > 0) || (buffer.z[i] > 0 && buffer.z[i] <= z)) continue;
      buffer.z[i] = z;
      buffer.what[i] = what;
    }
  }
}

void draw_clipped(const std::array<Eigen::Vector3d, 3>& corners, std::uint32_t what, const Camera& camera,
                  DepthBuffer& buffer) {
  std::array<Eigen::Vector3d, 4> kept;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& a = corners[i];
    const Eigen::Vector3d& b = corners[(i + 1) % 3];
    if (a.z() >= kNearest_m) kept[count++] = a;
    if ((a.z() >= kNearest_m) != (b.z() >= kNearest_m)) {
      kept[count++] = a + (b - a) * ((kNearest_m - a.z()) / (b.z() - a.z()));
    }
  }
  for (std::size_t i = 2; i < count; ++i) {
    fill({project(camera, kept[0]), project(camera, kept[i - 1]), project(camera, kept[i])}, what, buffer);
  }
}

}  // namespace

void draw(const Submesh& submesh, const std::vector<std::uint32_t>& what_of, const Pose& T_camera_node,
          const Camera& camera, DepthBuffer& buffer) {
  if (buffer.window.empty()) return;
  std::vector<Eigen::Vector3d> points;
  std::vector<Corner> pixels;
  points.reserve(submesh.positions.size());
  pixels.reserve(submesh.positions.size());
  for (const auto& p : submesh.positions) {
    points.push_back(T_camera_node * p.cast<double>());
    pixels.push_back(project(camera, points.back()));
  }
  for (std::size_t t = 0; t < submesh.triangles.size(); ++t) {
    if (what_of[t] == kNotDrawn) continue;
    const auto& [a, b, c] = submesh.triangles[t];
    const double nearest = std::min({points[a].z(), points[b].z(), points[c].z()});
    if (nearest >= kNearest_m) {
      fill({pixels[a], pixels[b], pixels[c]}, what_of[t], buffer);
    } else {
      draw_clipped({points[a], points[b], points[c]}, what_of[t], camera, buffer);
    }
  }
}

Window projected_window(const Eigen::AlignedBox3f& box, const Pose& T_camera_node, const Camera& camera, int margin) {
  if (box.isEmpty()) return {};
  double left = camera.width;
  double right = -1;
  double top = camera.height;
  double bottom = -1;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d p =
        T_camera_node * box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(k)).cast<double>();
    if (p.z() < kNearest_m) return {0, 0, camera.width, camera.height};
    const Eigen::Vector2d pixel = camera.project(p);
    left = std::min(left, pixel.x());
    right = std::max(right, pixel.x());
    top = std::min(top, pixel.y());
    bottom = std::max(bottom, pixel.y());
  }
  const auto clamped = [](double value, int size) { return static_cast<int>(std::clamp<double>(value, 0, size)); };
  const Window window{
      clamped(std::floor(left) - margin, camera.width), clamped(std::floor(top) - margin, camera.height),
      clamped(std::ceil(right) + margin + 1, camera.width), clamped(std::ceil(bottom) + margin + 1, camera.height)};
  return window.empty() ? Window{} : window;
}

Window common_part(const Window& a, const Window& b) {
  const Window window{std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
  return window.empty() ? Window{} : window;
}

Window around(const Window& a, const Window& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

}  // namespace meshloop::adjust
