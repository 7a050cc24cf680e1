#include "server/track/depth_in_color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace meshloop {
namespace {

// Within three pixels, more than this share of the distance is an edge.
constexpr double kEdgeShare = 0.02;
constexpr std::size_t kLeastMeasured = 5;

void splat(DepthImage& target, const Eigen::Vector2d& pixel, float z, int reach) {
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  for (int v = std::max(0, y - reach); v <= std::min(target.height() - 1, y + reach); ++v) {
    for (int u = std::max(0, x - reach); u <= std::min(target.width() - 1, x + reach); ++u) {
      float& there = target(u, v);
      if (there == 0 || z < there) there = z;
    }
  }
}

}  // namespace

DepthImage depth_in_color(const Rig& rig, const DepthImage& depth, const Pose& T_color_depth) {
  const Camera& source = rig.depth_registered ? rig.color : rig.depth;
  DepthImage mapped{rig.color.width, rig.color.height};
  if (depth.width() != source.width || depth.height() != source.height) return mapped;
  // A depth pixel covers this many colour pixels to each side of its middle one.
  const int reach = static_cast<int>(std::ceil(0.5 * (rig.color.fx / source.fx - 1) - 1e-9));
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const float z = depth(x, y);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const Eigen::Vector3d p_color = T_color_depth * source.back_project(x, y, z);
      if (!(p_color.z() > 0)) continue;
      const Eigen::Vector2d pixel = rig.color.project(p_color);
      if (!rig.color.contains(pixel)) continue;
      splat(mapped, pixel, static_cast<float>(p_color.z()), std::max(0, reach));
    }
  }
  return mapped;
}

std::optional<double> surface_depth_at(const DepthImage& depth, const Eigen::Vector2d& pixel) {
  if (!pixel.allFinite() || pixel.cwiseAbs().maxCoeff() > 1e5) return std::nullopt;
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  if (x < 1 || y < 1 || x >= depth.width() - 1 || y >= depth.height() - 1) return std::nullopt;
  std::array<float, 9> around{};
  std::size_t measured = 0;
  for (int k = 0; k < 9; ++k) {
    const float z = depth(x + k % 3 - 1, y + k / 3 - 1);
    if (z > 0) around[measured++] = z;
  }
  if (measured < kLeastMeasured) return std::nullopt;
  const auto end = around.begin() + static_cast<std::ptrdiff_t>(measured);
  std::sort(around.begin(), end);
  const double middle = around[measured / 2];
  if (*(end - 1) - around[0] > kEdgeShare * middle) return std::nullopt;
  return middle;
}

}  // namespace meshloop
