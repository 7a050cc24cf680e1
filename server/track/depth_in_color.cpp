#include "server/track/depth_in_color.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace meshloop {
namespace {

// A measurement further from the plane than this share of its depth, and than this many sigma, lies on another surface.
constexpr double kEdgeShare = 0.005;
constexpr double kEdgeSigma = 4;
// Pixels to each side that the plane is fitted to.
constexpr int kHalfWindow = 2;

void splat(DepthInColor& target, const MappedDepth& measured) {
  const int x = static_cast<int>(std::lround(measured.u));
  const int y = static_cast<int>(std::lround(measured.v));
  const int right = std::min(target.nearest.width() - 1, x + target.reach);
  const int bottom = std::min(target.nearest.height() - 1, y + target.reach);
  for (int v = std::max(0, y - target.reach); v <= bottom; ++v) {
    for (int u = std::max(0, x - target.reach); u <= right; ++u) {
      MappedDepth& there = target.nearest(u, v);
      if (there.z == 0 || measured.z < there.z) there = measured;
    }
  }
}

std::vector<MappedDepth> around(const DepthInColor& depth, int x, int y, int half) {
  std::vector<MappedDepth> measured;
  for (int v = y - half; v <= y + half; ++v) {
    for (int u = x - half; u <= x + half; ++u) {
      if (depth.nearest(u, v).z > 0) measured.push_back(depth.nearest(u, v));
    }
  }
  return measured;
}

// Inverse depth as a + b du + c dv around the pixel.
std::optional<Eigen::Vector3d> fit_plane(const std::vector<MappedDepth>& measured, const Eigen::Vector2d& pixel) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const MappedDepth& m : measured) {
    const Eigen::Vector3d row{1, m.u - pixel.x(), m.v - pixel.y()};
    information += row * row.transpose();
    sum += row / m.z;
  }
  // Measurements on a line, or one that covers the whole window, fix no plane.
  const double spread = information.bottomRightCorner<2, 2>().determinant();
  const auto count = static_cast<double>(measured.size());
  if (spread < 0.01 * count * count) return std::nullopt;
  return information.ldlt().solve(sum);
}

}  // namespace

DepthInColor depth_in_color(const Rig& rig, const DepthImage& depth, const Pose& T_color_depth) {
  const Camera& source = rig.depth_registered ? rig.color : rig.depth;
  DepthInColor mapped{{rig.color.width, rig.color.height}, 0};
  if (depth.width() != source.width || depth.height() != source.height) return mapped;
  mapped.reach = std::max(0, static_cast<int>(std::ceil(0.5 * (rig.color.fx / source.fx - 1) - 1e-9)));
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const float z = depth(x, y);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const Eigen::Vector3d p_color = T_color_depth * source.back_project(x, y, z);
      if (!(p_color.z() > 0)) continue;
      const Eigen::Vector2d pixel = rig.color.project(p_color);
      if (!rig.color.contains(pixel)) continue;
      splat(mapped, {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(p_color.z())});
    }
  }
  return mapped;
}

std::optional<double> surface_depth_at(const DepthInColor& depth, const Eigen::Vector2d& pixel,
                                       const SensorModel& sensor) {
  if (!pixel.allFinite() || pixel.cwiseAbs().maxCoeff() > 1e5) return std::nullopt;
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  const int half = kHalfWindow * (1 + depth.reach);
  if (x < half || y < half || x >= depth.nearest.width() - half || y >= depth.nearest.height() - half) {
    return std::nullopt;
  }
  const std::vector<MappedDepth> measured = around(depth, x, y, half);
  const int window = (2 * half + 1) * (2 * half + 1);
  if (2 * static_cast<int>(measured.size()) < window) return std::nullopt;
  const auto plane = fit_plane(measured, pixel);
  if (!plane || !((*plane)[0] > 0)) return std::nullopt;
  const double z = 1 / (*plane)[0];
  const double limit = std::max(kEdgeShare * z, kEdgeSigma * sensor.sigma_z_m(z, 0));
  const bool one_surface = std::all_of(measured.begin(), measured.end(), [&](const MappedDepth& m) {
    const double inverse = plane->dot(Eigen::Vector3d{1, m.u - pixel.x(), m.v - pixel.y()});
    return std::abs(inverse - 1 / m.z) * z * z <= limit;
  });
  return one_surface ? std::optional{z} : std::nullopt;
}

}  // namespace meshloop
