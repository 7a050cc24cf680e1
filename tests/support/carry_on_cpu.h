#pragma once
// Which depth pixel each pixel of the colour camera sees, on the CPU and in another way than server/show: squares that
// face the camera, drawn pixel by pixel into a depth buffer. Reference of tests and benchmarks.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/change/comparison.h"
#include "common/geometry/rig.h"
#include "common/image/image.h"

namespace meshloop {

/// Draws squares into a depth buffer of the colour camera.
class SquareDrawer {
 public:
  /// Neighbours on a slanted surface move apart, so squares are a little larger than their pixels.
  static constexpr float kEnlarged = 1.1f;

  SquareDrawer(const Rig& rig, ImageView<std::uint32_t> source)
      : source_{source}, nearest_{source.width(), source.height(), std::numeric_limits<float>::max()} {
    const Pose T_color_depth = rig.T_depth_color.inverse();
    // K_color * R * K_depth^-1 and K_color * t: a depth pixel goes to its place in the colour image in one step.
    Eigen::Matrix3d K_color;
    K_color << rig.color.fx, 0, rig.color.cx, 0, rig.color.fy, rig.color.cy, 0, 0, 1;
    Eigen::Matrix3d K_depth;
    K_depth << rig.depth.fx, 0, rig.depth.cx, 0, rig.depth.fy, rig.depth.cy, 0, 0, 1;
    H_ = (K_color * T_color_depth.linear() * K_depth.inverse()).cast<float>();
    h_ = (K_color * T_color_depth.translation()).cast<float>();
    half_width_ = static_cast<float>(rig.color.fx / rig.depth.fx / 2) * kEnlarged;
    half_height_ = static_cast<float>(rig.color.fy / rig.depth.fy / 2) * kEnlarged;
  }

  void draw(int u, int v, float z, std::uint32_t source, bool only_where_free) {
    const Eigen::Vector3f p = z * (H_ * Eigen::Vector3f{static_cast<float>(u), static_cast<float>(v), 1}) + h_;
    if (!(p.z() > 0.01f)) return;
    const float per_z = 1 / p.z();
    const float x = p.x() * per_z;
    const float y = p.y() * per_z;
    if (!(std::abs(x) < 1e5f && std::abs(y) < 1e5f)) return;
    const float nearer = std::min(z * per_z, 8.0f);
    const int x0 = std::max(ceil_of(x - half_width_ * nearer), 0);
    const int x1 = std::min(ceil_of(x + half_width_ * nearer), nearest_.width());
    const int y0 = std::max(ceil_of(y - half_height_ * nearer), 0);
    const int y1 = std::min(ceil_of(y + half_height_ * nearer), nearest_.height());
    for (int row = y0; row < y1; ++row) {
      const auto first = static_cast<std::ptrdiff_t>(row) * nearest_.width();
      for (int column = x0; column < x1; ++column) {
        float& nearest = nearest_.data()[first + column];
        std::uint32_t& seen = source_.data()[first + column];
        if (p.z() >= nearest || (only_where_free && seen != 0)) continue;
        nearest = p.z();
        seen = source;
      }
    }
  }

 private:
  // std::ceil without its call; x is within an int.
  static int ceil_of(float x) {
    const int truncated = static_cast<int>(x);
    return truncated + (static_cast<float>(truncated) < x ? 1 : 0);
  }

  ImageView<std::uint32_t> source_;
  DepthImage nearest_;
  Eigen::Matrix3f H_;
  Eigen::Vector3f h_;
  float half_width_ = 0;
  float half_height_ = 0;
};

/// As show::Carrier::carry.
inline Image<std::uint32_t> carry_on_cpu(const Comparison& comparison, const DepthImage& measured, const Rig& rig) {
  Image<std::uint32_t> source{rig.color.width, rig.color.height};
  SquareDrawer drawer{rig, source.view()};
  const auto draw_all = [&](const DepthImage& depth, bool unmeasured) {
    std::uint32_t i = 0;
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u, ++i) {
        const float z = depth.data()[i];
        const bool wanted = !unmeasured || comparison.labels.data()[i] == Label::unmeasured;
        if (z > 0 && wanted) drawer.draw(u, v, z, i + 1, unmeasured);
      }
    }
  };
  draw_all(measured, false);
  draw_all(comparison.expected, true);
  return source;
}

}  // namespace meshloop
