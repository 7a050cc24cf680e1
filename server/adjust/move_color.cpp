#include "server/adjust/move_color.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/image/jpeg_codec.h"

namespace meshloop::adjust {
namespace {

constexpr std::size_t kMostSamples = 3000;
constexpr int kLeastSamples = 40;
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

/// What of a part is drawn at a pose.
struct DrawnPart {
  const MoveScene& scene;
  const Part& part;
  const Pose& T_camera_node;
  DepthBuffer buffer;

  DrawnPart(const MoveScene& of_scene, const Part& of_part, const Pose& pose)
      : scene{of_scene},
        part{of_part},
        T_camera_node{pose},
        buffer{projected_window(part.submesh.bounds(), T_camera_node, scene.camera(), 1)} {
    draw(part.submesh, part.counted, T_camera_node, scene.camera(), buffer);
  }
  [[nodiscard]] float sigma_m(double z) const {
    return static_cast<float>(scene.snapshot->rig->sensor.sigma_z_m(z, 0));
  }
};

/// The colours of vertices that are seen.
void add_vertices(const DrawnPart& drawn, const ColorLookup& colors, Sums& sums) {
  const auto& [scene, part, T_camera_node, buffer] = drawn;
  const std::size_t every = part.submesh.positions.size() / kMostSamples + 1;
  for (std::size_t i = 0; i < part.submesh.positions.size(); i += every) {
    const Eigen::Vector3d p = T_camera_node * part.submesh.positions[i].cast<double>();
    if (!(p.z() > 0.05)) continue;
    const Eigen::Vector2d pixel = scene.camera().project(p);
    const auto x = static_cast<int>(std::floor(pixel.x() + 0.5));
    const auto y = static_cast<int>(std::floor(pixel.y() + 0.5));
    const auto z = static_cast<double>(buffer.depth(x, y));
    if (!(z > 0)) continue;
    const auto normal = normal_of(part, T_camera_node, buffer.what[buffer.at(x, y)]);
    if (std::abs(z - p.z()) > scene.tolerance.at(p, normal)) continue;
    const auto seen = colors.color_of(p.cast<float>(), drawn.sigma_m(p.z()));
    if (seen) sums.add(part.submesh.colors[i], *seen);
  }
}

/// The texture's colours, spread over the pixels that show the part.
void add_pixels(const DrawnPart& drawn, const PartColors& colors, Sums& sums) {
  const DepthBuffer& buffer = drawn.buffer;
  const Pose T_node_camera = drawn.T_camera_node.inverse();
  const auto shown =
      static_cast<std::size_t>(std::count_if(buffer.z.begin(), buffer.z.end(), [](float z) { return z > 0; }));
  const std::size_t every = shown / kMostSamples + 1;
  std::size_t count = 0;
  for (int y = buffer.window.y0; y < buffer.window.y1; ++y) {
    for (int x = buffer.window.x0; x < buffer.window.x1; ++x) {
      const auto z = static_cast<double>(buffer.depth(x, y));
      if (!(z > 0) || count++ % every != 0) continue;
      const Eigen::Vector3d p = drawn.scene.camera().back_project(x, y, z);
      const Eigen::Vector3f p_node = (T_node_camera * p).cast<float>();
      const auto seen = colors.seen.color_of(p.cast<float>(), drawn.sigma_m(z));
      if (seen) sums.add(bilinear(colors.picture, pixel_of(*drawn.part.submesh.texture, p_node)), *seen);
    }
  }
}

}  // namespace

PartColors colors_of(const Part& part, const ColorLookup& seen) {
  const auto& texture = part.submesh.texture;
  return {texture ? decode_jpeg(texture->jpeg).value_or(ColorImage{}) : ColorImage{}, seen};
}

std::optional<double> color_agreement(const MoveScene& scene, const Part& part, const PartColors& colors,
                                      const Pose& T_camera_node) {
  Sums sums;
  if (part.submesh.texture) {
    if (!colors.picture.empty()) add_pixels({scene, part, T_camera_node}, colors, sums);
  } else if (part.submesh.has_colors()) {
    add_vertices({scene, part, T_camera_node}, colors.seen, sums);
  }
  if (sums.count < kLeastSamples) return std::nullopt;
  const double n = sums.count;
  const double variance_a = (sums.aa - sums.a * sums.a / n).sum() / (3 * n);
  const double variance_b = (sums.bb - sums.b * sums.b / n).sum() / (3 * n);
  if (std::min(variance_a, variance_b) < kTexture * kTexture) return std::nullopt;
  return (sums.ab - sums.a * sums.b / n).sum() / (3 * n) / std::sqrt(variance_a * variance_b);
}

}  // namespace meshloop::adjust
