#include "server/adjust/patch_points.h"

#include <algorithm>
#include <array>

#include "common/base/target_clones.h"

namespace meshloop::adjust {
namespace {

/// What makes a point of a pixel of the window and its depth.
struct Rays {
  float corner_u;
  float corner_v;
  float per_fx;
  float per_fy;
};

// Pixels of one row, by their numbers in the window; `begin` is that of the row's first.
MESHLOOP_TARGET_CLONES
void project_row(const Rays& rays, const std::uint32_t* pixels, std::size_t count, std::uint32_t begin, float row,
                 const float* z, float* points) {
  const float corner_u = rays.corner_u;
  const float per_fx = rays.per_fx;
  const float y = (row + rays.corner_v) * rays.per_fy;
  for (std::size_t n = 0; n < count; ++n) {
    const float depth = z[pixels[n]];
    const auto column = static_cast<float>(static_cast<std::int32_t>(pixels[n] - begin));
    points[3 * n] = (column + corner_u) * depth * per_fx;
    points[3 * n + 1] = y * depth;
    points[3 * n + 2] = depth;
  }
}

MESHLOOP_TARGET_CLONES
void transform(const std::array<float, 12>& T, const float* points, std::size_t count, float* moved) {
  const std::array<float, 12> t = T;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = points[3 * i];
    const float y = points[3 * i + 1];
    const float z = points[3 * i + 2];
    moved[3 * i] = t[0] * x + t[1] * y + t[2] * z + t[3];
    moved[3 * i + 1] = t[4] * x + t[5] * y + t[6] * z + t[7];
    moved[3 * i + 2] = t[8] * x + t[9] * y + t[10] * z + t[11];
  }
}

}  // namespace

std::vector<Eigen::Vector3f> back_project(const DepthGrid& grid, const VertexPlaces& moved, const Camera& camera,
                                          const GridVertices& vertices) {
  const auto& pixels = vertices.pixels;
  std::vector<Eigen::Vector3f> points(pixels.size());
  const Rays rays{static_cast<float>(grid.window.x0 - camera.cx), static_cast<float>(grid.window.y0 - camera.cy),
                  static_cast<float>(1 / camera.fx), static_cast<float>(1 / camera.fy)};
  const auto w = static_cast<std::uint32_t>(grid.window.width());
  for (std::size_t n = 0; n < pixels.size();) {
    const std::uint32_t row = pixels[n] / w;
    const auto end = std::lower_bound(pixels.begin() + static_cast<std::ptrdiff_t>(n), pixels.end(), (row + 1) * w);
    const auto count = static_cast<std::size_t>(end - pixels.begin()) - n;
    project_row(rays, &pixels[n], count, row * w, static_cast<float>(row), grid.z.data(), points[n].data());
    n += count;
  }
  if (moved.places.empty()) return points;
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    const Eigen::Vector3f& p = moved.places[pixels[n]];
    if (p.z() > 0) {
      points[n] = {(p.x() + rays.corner_u) * p.z() * rays.per_fx, (p.y() + rays.corner_v) * p.z() * rays.per_fy, p.z()};
    }
  }
  return points;
}

std::vector<Eigen::Vector3f> transformed(const Eigen::Isometry3f& T, const std::vector<Eigen::Vector3f>& points) {
  std::array<float, 12> rows{};
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column)
      rows[static_cast<std::size_t>(4 * row + column)] = T.matrix()(row, column);
  }
  std::vector<Eigen::Vector3f> moved(points.size());
  if (!points.empty()) transform(rows, points.front().data(), points.size(), moved.front().data());
  return moved;
}

}  // namespace meshloop::adjust
