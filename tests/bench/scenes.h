#pragma once
// Models of any number of triangles, and what a camera measures of them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <utility>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/mesh/model.h"

namespace meshloop::bench {

/// A grid of cells x cells squares over (s, t) in [0, 1], two triangles each.
inline Submesh grid(int cells, const std::function<Eigen::Vector3f(float, float)>& at) {
  Submesh submesh;
  for (int i = 0; i <= cells; ++i) {
    for (int j = 0; j <= cells; ++j) {
      submesh.positions.push_back(
          at(static_cast<float>(j) / static_cast<float>(cells), static_cast<float>(i) / static_cast<float>(cells)));
    }
  }
  const auto row = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t i = 0; i + 1 < row; ++i) {
    for (std::uint32_t j = 0; j + 1 < row; ++j) {
      const std::uint32_t here = i * row + j;
      submesh.triangles.push_back({here, here + row, here + 1});
      submesh.triangles.push_back({here + 1, here + row, here + row + 1});
    }
  }
  return submesh;
}

/// The parts of a surface as nodes of at most `kTilesAcross`^2 pieces, as an import would cut it.
template <class Surface>
void add_surface(Model& model, int tiles_across, int cells, const Surface& surface) {
  for (int tile = 0; tile < tiles_across * tiles_across; ++tile) {
    const auto column = static_cast<float>(tile % tiles_across);
    const auto row = static_cast<float>(tile / tiles_across);
    const auto count = static_cast<float>(tiles_across);
    auto submesh = grid(cells, [&](float s, float t) { return surface((column + s) / count, (row + t) / count); });
    model.nodes.push_back(make_node(model.nodes.size() + 1, "tile", std::move(submesh)));
  }
}

inline int cells_per_tile(std::int64_t triangles, int tiles) {
  return std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 2 / tiles))));
}

/// A wavy surface of 4 x 4 m, 1.5 to 2.5 m in front of the camera at the origin, whose view it more than fills: a fifth
/// of the triangles is seen.
inline Model relief(std::int64_t triangles) {
  constexpr int kTilesAcross = 5;
  Model model;
  add_surface(model, kTilesAcross, cells_per_tile(triangles, kTilesAcross * kTilesAcross), [](float s, float t) {
    const float x = 4 * s - 2;
    const float y = 4 * t - 2;
    return Eigen::Vector3f{x, y, 2 + 0.5F * std::sin(5 * x) * std::cos(4 * y)};
  });
  return model;
}

/// As a scan leaves it: rough by some millimetres, the same at every call.
inline float roughness(float x, float y, float z) {
  const float waves = std::sin(61 * x + 3) * std::sin(47 * y + 1) * std::sin(53 * z + 2);
  return 0.002F * waves + 0.0015F * std::sin(170 * (x + y)) * std::sin(190 * (y + z));
}

/// The inside of a room of 5 x 4 x 2.6 m (y points down) with bays in its walls; the camera stands in it, at the
/// origin.
inline Model room(std::int64_t triangles) {
  constexpr int kTilesAcross = 3;
  const int cells = cells_per_tile(triangles, 6 * kTilesAcross * kTilesAcross);
  Model model;
  const Eigen::Vector3f half{2.5F, 1.3F, 2.0F};
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const float side = face % 2 == 0 ? 1.0F : -1.0F;
    add_surface(model, kTilesAcross, cells, [&](float s, float t) {
      // Seen from inside the triangles are counter-clockwise on every face.
      const float first = side > 0 ? s : 1 - s;
      Eigen::Vector3f unit;
      unit[axis] = side;
      unit[(axis + 1) % 3] = 2 * first - 1;
      unit[(axis + 2) % 3] = 2 * t - 1;
      Eigen::Vector3f p = unit.cwiseProduct(half);
      const float bay = 0.12F * std::tanh(8 * std::sin(2.2F * p[(axis + 1) % 3]) * std::sin(2.6F * p[(axis + 2) % 3]));
      p[axis] -= side * (bay + 0.15F + roughness(p.x(), p.y(), p.z()));
      return p;
    });
  }
  return model;
}

/// A closed surface around the origin, `rings` from pole to pole; `at` gives the point in a direction of length one.
inline Submesh closed_surface(int rings, const std::function<Eigen::Vector3f(const Eigen::Vector3f&)>& at) {
  const int around = 2 * rings;
  Submesh submesh;
  const auto add = [&](double polar, double angle) {
    const Eigen::Vector3d direction{std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle),
                                    std::cos(polar)};
    submesh.positions.push_back(at(direction.cast<float>()));
  };
  add(0, 0);
  for (int ring = 1; ring < rings; ++ring) {
    for (int k = 0; k < around; ++k) add(std::numbers::pi * ring / rings, 2 * std::numbers::pi * k / around);
  }
  add(std::numbers::pi, 0);
  const auto last = static_cast<std::uint32_t>(submesh.positions.size() - 1);
  const auto vertex = [&](int ring, int k) {
    if (ring == 0 || ring == rings) return ring == 0 ? 0U : last;
    return static_cast<std::uint32_t>(1 + (ring - 1) * around + k % around);
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int k = 0; k < around; ++k) {
      if (ring > 0) submesh.triangles.push_back({vertex(ring, k), vertex(ring + 1, k), vertex(ring, k + 1)});
      if (ring + 1 < rings)
        submesh.triangles.push_back({vertex(ring, k + 1), vertex(ring + 1, k), vertex(ring + 1, k + 1)});
    }
  }
  return submesh;
}

/// 42 rough stones, closed and each a node, 2 m in front of the camera and no farther apart than they are large.
inline Model stones(std::int64_t triangles) {
  constexpr int kAcross = 7;
  constexpr int kDown = 6;
  const int rings =
      std::max(3, static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / (4 * kAcross * kDown)))));
  Model model;
  for (int i = 0; i < kAcross * kDown; ++i) {
    const Eigen::Vector3f center{0.28F * static_cast<float>(i % kAcross - 3),
                                 0.28F * (static_cast<float>(i / kAcross) - 2.5F),
                                 2 + 0.2F * std::sin(static_cast<float>(i))};
    auto stone = closed_surface(rings, [&](const Eigen::Vector3f& direction) {
      const Eigen::Vector3f p = center + 0.14F * direction;
      return Eigen::Vector3f{p + (0.01F * std::sin(20 * (p.x() + p.y())) + roughness(p.x(), p.y(), p.z())) * direction};
    });
    model.nodes.push_back(make_node(model.nodes.size() + 1, "stone", std::move(stone)));
  }
  return model;
}

}  // namespace meshloop::bench
