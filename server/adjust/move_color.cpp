#include "server/adjust/move_color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace meshloop::adjust {
namespace {

constexpr std::size_t kMostVertices = 3000;
constexpr int kLeastVertices = 40;
/// Standard deviation of what is not even, in grey levels.
constexpr double kTexture = 10;

using Values = Eigen::Array3d;

/// Sums over pairs of colours.
struct Sums {
  int count = 0;
  Values a = Values::Zero();
  Values b = Values::Zero();
  Values aa = Values::Zero();
  Values bb = Values::Zero();
  Values ab = Values::Zero();

  void add(const Rgb8& first, const Rgb8& second) {
    const Values p{static_cast<double>(first.r), static_cast<double>(first.g), static_cast<double>(first.b)};
    const Values q{static_cast<double>(second.r), static_cast<double>(second.g), static_cast<double>(second.b)};
    ++count;
    a += p;
    b += q;
    aa += p * p;
    bb += q * q;
    ab += p * q;
  }
};

}  // namespace

std::optional<double> color_agreement(const MoveScene& scene, const Part& part, const ColorLookup& colors,
                                      const Pose& T_camera_node) {
  if (!part.submesh.has_colors()) return std::nullopt;
  const Camera& camera = scene.camera();
  DepthBuffer drawn{projected_window(part.submesh.bounds(), T_camera_node, camera, 1)};
  draw(part.submesh, part.counted, T_camera_node, camera, drawn);
  const std::size_t every = part.submesh.positions.size() / kMostVertices + 1;
  Sums sums;
  for (std::size_t i = 0; i < part.submesh.positions.size(); i += every) {
    const Eigen::Vector3d p = T_camera_node * part.submesh.positions[i].cast<double>();
    if (!(p.z() > 0.05)) continue;
    const Eigen::Vector2d pixel = camera.project(p);
    const auto x = static_cast<int>(std::floor(pixel.x() + 0.5));
    const auto y = static_cast<int>(std::floor(pixel.y() + 0.5));
    const auto z = static_cast<double>(drawn.depth(x, y));
    if (!(z > 0)) continue;
    const auto normal = normal_of(part, T_camera_node, drawn.what[drawn.at(x, y)]);
    if (std::abs(z - p.z()) > scene.tolerance.at(p, normal)) continue;
    const auto sigma_m = static_cast<float>(scene.snapshot->rig->sensor.sigma_z_m(p.z(), 0));
    const auto seen = colors.color_of(p.cast<float>(), sigma_m);
    if (seen) sums.add(part.submesh.colors[i], *seen);
  }
  if (sums.count < kLeastVertices) return std::nullopt;
  const double n = sums.count;
  const double variance_a = (sums.aa - sums.a * sums.a / n).sum() / (3 * n);
  const double variance_b = (sums.bb - sums.b * sums.b / n).sum() / (3 * n);
  if (std::min(variance_a, variance_b) < kTexture * kTexture) return std::nullopt;
  return (sums.ab - sums.a * sums.b / n).sum() / (3 * n) / std::sqrt(variance_a * variance_b);
}

}  // namespace meshloop::adjust
