#include "server/adjust/color_lookup.h"

#include <algorithm>
#include <cmath>

#include "common/mesh/lattice.h"
#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {
namespace {

constexpr float kNothing = 1e9f;
// The error of rounding is 2.3 levels as root mean square, about a camera's noise; finer colours would mostly send that
// noise. Steps of four take a tenth more bytes.
constexpr float kColorStep = kCoarseColorStep;
constexpr float kLargest = 256 - kColorStep;

std::uint8_t mix(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d, float fx, float fy) {
  const float top = static_cast<float>(a) + (static_cast<float>(b) - static_cast<float>(a)) * fx;
  const float bottom = static_cast<float>(c) + (static_cast<float>(d) - static_cast<float>(c)) * fx;
  const float value = std::floor((top + (bottom - top) * fy) / kColorStep + 0.5f) * kColorStep;
  return static_cast<std::uint8_t>(std::min(value, kLargest));
}

}  // namespace

ColorLookup::ColorLookup(const Snapshot& snapshot) : color_{&snapshot.frame->color}, camera_{snapshot.rig->color} {
  const Pose T_color_depth = snapshot.rig->T_depth_color.inverse();
  R_color_depth_ = T_color_depth.linear().cast<float>();
  t_color_depth_ = T_color_depth.translation().cast<float>();
  if (color_->width() != camera_.width || color_->height() != camera_.height) return;
  const Camera& depth = snapshot.rig->depth;
  scale_ = static_cast<float>(std::min(1.0, depth.fx / camera_.fx));
  step_per_m_ = static_cast<float>(2 * kSteepest / std::min(depth.fx, depth.fy));
  draw(snapshot.frame->depth, depth);
}

void ColorLookup::draw(const DepthImage& measured, const Camera& depth) {
  const int w = static_cast<int>(std::ceil(static_cast<float>(camera_.width) * scale_)) + 1;
  const int h = static_cast<int>(std::ceil(static_cast<float>(camera_.height) * scale_)) + 1;
  nearest_ = DepthImage{w, h, kNothing};
  const auto per_fx = static_cast<float>(1 / depth.fx);
  const auto per_fy = static_cast<float>(1 / depth.fy);
  const float fx = static_cast<float>(camera_.fx) * scale_;
  const float fy = static_cast<float>(camera_.fy) * scale_;
  const float cx = static_cast<float>(camera_.cx) * scale_;
  const float cy = static_cast<float>(camera_.cy) * scale_;
  for (int v = 0; v < measured.height(); ++v) {
    const float y_ray = (static_cast<float>(v) - static_cast<float>(depth.cy)) * per_fy;
    const float* row = measured.data() + static_cast<std::ptrdiff_t>(v) * measured.width();
    for (int u = 0; u < measured.width(); ++u) {
      const float z = row[u];
      if (!(z > 0)) continue;
      const float x_ray = (static_cast<float>(u) - static_cast<float>(depth.cx)) * per_fx;
      const Eigen::Vector3f p = R_color_depth_ * Eigen::Vector3f{x_ray * z, y_ray * z, z} + t_color_depth_;
      if (!(p.z() > 0.01f)) continue;
      const float fu = fx * p.x() / p.z() + cx;
      const float fv = fy * p.y() / p.z() + cy;
      if (!(fu >= 0 && fv >= 0 && fu < static_cast<float>(w - 1) && fv < static_cast<float>(h - 1))) continue;
      float* cell = nearest_.data() + static_cast<std::ptrdiff_t>(fv) * w + static_cast<std::ptrdiff_t>(fu);
      cell[0] = std::min(cell[0], p.z());
      cell[1] = std::min(cell[1], p.z());
      cell[w] = std::min(cell[w], p.z());
      cell[w + 1] = std::min(cell[w + 1], p.z());
    }
  }
}

std::optional<Rgb8> ColorLookup::bilinear(float u, float v) const {
  const auto last_x = static_cast<float>(color_->width() - 1);
  const auto last_y = static_cast<float>(color_->height() - 1);
  if (!(u >= -0.5f && v >= -0.5f && u <= last_x + 0.5f && v <= last_y + 0.5f)) return std::nullopt;
  u = std::clamp(u, 0.0f, last_x);
  v = std::clamp(v, 0.0f, last_y);
  const int x = std::min(static_cast<int>(u), color_->width() - 2);
  const int y = std::min(static_cast<int>(v), color_->height() - 2);
  const float fx = u - static_cast<float>(x);
  const float fy = v - static_cast<float>(y);
  const Rgb8* p = color_->data() + static_cast<std::ptrdiff_t>(y) * color_->width() + x;
  const Rgb8* q = p + color_->width();
  return Rgb8{mix(p[0].r, p[1].r, q[0].r, q[1].r, fx, fy), mix(p[0].g, p[1].g, q[0].g, q[1].g, fx, fy),
              mix(p[0].b, p[1].b, q[0].b, q[1].b, fx, fy)};
}

std::optional<Rgb8> ColorLookup::color_of(const Eigen::Vector3f& p_depth, float sigma_m) const {
  const Eigen::Vector3f p = R_color_depth_ * p_depth + t_color_depth_;
  if (nearest_.empty() || !(p.z() > 0.01f)) return std::nullopt;
  const float u = static_cast<float>(camera_.fx) * p.x() / p.z() + static_cast<float>(camera_.cx);
  const float v = static_cast<float>(camera_.fy) * p.y() / p.z() + static_cast<float>(camera_.cy);
  const auto color = bilinear(u, v);
  if (!color) return std::nullopt;
  const auto cell_x = static_cast<int>(std::max(u * scale_ + 0.5f, 0.0f));
  const auto cell_y = static_cast<int>(std::max(v * scale_ + 0.5f, 0.0f));
  const float nearest = nearest_(std::min(cell_x, nearest_.width() - 1), std::min(cell_y, nearest_.height() - 1));
  if (p.z() > nearest + 3 * sigma_m + p.z() * step_per_m_) return std::nullopt;
  return color;
}

}  // namespace meshloop::adjust
