#pragma once
// Meshes that the codec's tests share.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <tuple>
#include <vector>

#include "common/mesh/lattice.h"
#include "common/mesh/submesh.h"

namespace meshloop::test {

struct GridLook {
  /// Noise along the ray, metres; the Kinect's at 1 m is 2 mm.
  float sigma_m = 0.002f;
  float texture = 20;
  float pixel_noise = 2;
};

/// What a depth camera (585 px focal length at 640 px width) sees of a gently curved wall at 1 m, in world coordinates
/// turned against the camera's, with depths in whole millimetres.
inline Submesh depth_grid(int width, int height, const GridLook& look = {}) {
  std::mt19937 random{7};
  std::normal_distribution<float> gauss;
  const Eigen::Matrix3f R = Eigen::AngleAxisf(0.9f, Eigen::Vector3f(1, 0.7f, 0.3f).normalized()).toRotationMatrix();
  const float focal = 585.0f * static_cast<float>(width) / 640;
  const auto channel = [](float value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0f, 255.0f)); };
  Submesh grid;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float fx = static_cast<float>(x), fy = static_cast<float>(y);
      const float u = (fx - static_cast<float>(width - 1) / 2) / focal;
      const float v = (fy - static_cast<float>(height - 1) / 2) / focal;
      const float z = 1 + 0.1f * std::sin(3 * u) * std::cos(2 * v) + look.sigma_m * gauss(random);
      grid.positions.push_back(R * Eigen::Vector3f(u, v, 1) * (std::round(z * 1000) / 1000));
      const float light = look.texture * std::sin(fx * 0.2f) * std::sin(fy * 0.15f) + look.pixel_noise * gauss(random);
      const auto noisy = [&](float value) { return channel(value + light + look.pixel_noise / 2 * gauss(random)); };
      grid.colors.push_back(
          {noisy(120 + 40 * std::sin(u * 4)), noisy(100 + 40 * std::cos(v * 3)), noisy(90 + 30 * std::sin(u * 5 + v))});
    }
  }
  for (int y = 0; y + 1 < height; ++y) {
    for (int x = 0; x + 1 < width; ++x) {
      const auto a = static_cast<std::uint32_t>(y * width + x), below = a + static_cast<std::uint32_t>(width);
      grid.triangles.push_back({a, below, a + 1});
      grid.triangles.push_back({a + 1, below, below + 1});
    }
  }
  return snap_to_lattice(grid);
}

using Corner = std::tuple<float, float, float, int, int, int>;
using Face = std::array<Corner, 3>;

/// The triangles as a sorted list of exact positions and colours: equal for meshes that differ in order only. Each
/// is turned to its smallest order, so that the winding counts.
inline std::vector<Face> faces_of(const Submesh& submesh) {
  std::vector<Face> faces;
  for (const auto& triangle : submesh.triangles) {
    Face face;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = submesh.positions[triangle[k]];
      const Rgb8 color = submesh.has_colors() ? submesh.colors[triangle[k]] : Rgb8{};
      face[k] = {p.x(), p.y(), p.z(), color.r, color.g, color.b};
    }
    const Face once{face[1], face[2], face[0]}, twice{face[2], face[0], face[1]};
    faces.push_back(std::min({face, once, twice}));
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// A flat strip of `cells` squares on the lattice, without colours.
inline Submesh strip(int cells, float size_m = 0.125f) {
  Submesh mesh;
  for (int i = 0; i <= cells; ++i) {
    mesh.positions.emplace_back(static_cast<float>(i) * size_m, 0.0f, 0.0f);
    mesh.positions.emplace_back(static_cast<float>(i) * size_m, size_m, 0.0f);
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(cells); ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    mesh.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  return mesh;
}

}  // namespace meshloop::test
