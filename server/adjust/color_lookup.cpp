#include "server/adjust/color_lookup.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "common/mesh/lattice.h"
#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {
namespace {

constexpr float kNothing = 1e9f;
// The error of rounding is 2.3 levels as root mean square, about a camera's noise; finer colours would mostly send that
// noise. Steps of four take a tenth more bytes.
constexpr std::uint64_t kColorStep = kCoarseColorStep;
static_assert(kColorStep == 8);

/// Red, green and blue side by side in one number, so that one multiplication weighs all three.
constexpr int kLane_bits = 21;
/// Fractions of a pixel are in units of 1 / 32, so that two weights and a level of 255 fit into a lane.
constexpr std::uint64_t kUnit = 32;

std::uint64_t lanes(const Rgb8& p) {
  return static_cast<std::uint64_t>(p.r) | static_cast<std::uint64_t>(p.g) << kLane_bits |
         static_cast<std::uint64_t>(p.b) << (2 * kLane_bits);
}

constexpr std::uint64_t in_each_lane(std::uint64_t value) {
  return value | value << kLane_bits | value << (2 * kLane_bits);
}

// All three lanes at once: to the nearest step, of which there are 32; what would be the 33rd is the 32nd.
Rgb8 rounded(std::uint64_t sum) {
  constexpr std::uint64_t kStep = kColorStep * kUnit * kUnit;
  constexpr int kStep_bits = std::countr_zero(kStep);
  const std::uint64_t steps = (sum + in_each_lane(kStep / 2)) >> kStep_bits & in_each_lane(63);
  const std::uint64_t levels = (steps - (steps >> 5 & in_each_lane(1))) * kColorStep;
  return {static_cast<std::uint8_t>(levels), static_cast<std::uint8_t>(levels >> kLane_bits),
          static_cast<std::uint8_t>(levels >> (2 * kLane_bits))};
}

/// Shares of the pixels at -1, 0, 1 and 2 in what lies at `t`, from 0 to 1: cubic convolution (Keys 1981, a = -1/2).
std::array<float, 4> cubic_shares(float t) {
  return {((-0.5f * t + 1) * t - 0.5f) * t, (1.5f * t - 2.5f) * t * t + 1, ((-1.5f * t + 2) * t + 0.5f) * t,
          (0.5f * t - 0.5f) * t * t};
}

/// The picture's border goes on beyond it.
Rgb8 cubic(const ColorImage& image, const Eigen::Vector2f& pixel) {
  const int x = static_cast<int>(std::floor(pixel.x()));
  const int y = static_cast<int>(std::floor(pixel.y()));
  const auto across = cubic_shares(pixel.x() - static_cast<float>(x));
  const auto down = cubic_shares(pixel.y() - static_cast<float>(y));
  Eigen::Array3f sum = Eigen::Array3f::Zero();
  for (int k = 0; k < 16; ++k) {
    const int u = std::clamp(x + k % 4 - 1, 0, image.width() - 1);
    const int v = std::clamp(y + k / 4 - 1, 0, image.height() - 1);
    const Rgb8& p = image(u, v);
    sum += across[static_cast<std::size_t>(k % 4)] * down[static_cast<std::size_t>(k / 4)] *
           Eigen::Array3f{static_cast<float>(p.r), static_cast<float>(p.g), static_cast<float>(p.b)};
  }
  const auto level = [](float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); };
  return {level(sum.x()), level(sum.y()), level(sum.z())};
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
  const auto columns = static_cast<std::size_t>(measured.width());
  std::vector<float> u(columns);
  std::vector<float> v(columns);
  std::vector<float> z(columns);
  for (int y = 0; y < measured.height(); ++y) {
    project_row(measured, y, depth, {u.data(), v.data(), z.data()});
    for (std::size_t x = 0; x < columns; ++x) {
      if (!(z[x] > 0.01f && u[x] >= 0 && v[x] >= 0 && u[x] < static_cast<float>(w - 1) &&
            v[x] < static_cast<float>(h - 1)))
        continue;
      float* cell = nearest_.data() + static_cast<std::ptrdiff_t>(v[x]) * w + static_cast<std::ptrdiff_t>(u[x]);
      cell[0] = std::min(cell[0], z[x]);
      cell[1] = std::min(cell[1], z[x]);
      cell[w] = std::min(cell[w], z[x]);
      cell[w + 1] = std::min(cell[w + 1], z[x]);
    }
  }
}

// Without branches, so that several pixels are projected at once; what was not measured comes to lie behind the camera.
void ColorLookup::project_row(const DepthImage& measured, int y, const Camera& depth, const Places& places) const {
  const float fx = static_cast<float>(camera_.fx) * scale_;
  const float fy = static_cast<float>(camera_.fy) * scale_;
  const float cx = static_cast<float>(camera_.cx) * scale_;
  const float cy = static_cast<float>(camera_.cy) * scale_;
  const auto per_fx = static_cast<float>(1 / depth.fx);
  const auto depth_cx = static_cast<float>(depth.cx);
  const Eigen::Vector3f along = R_color_depth_.col(0) * per_fx;
  const Eigen::Vector3f first =
      R_color_depth_ * Eigen::Vector3f{0, static_cast<float>((y - depth.cy) / depth.fy), 1} - along * depth_cx;
  const Eigen::Vector3f t = t_color_depth_;
  const float* row = measured.data() + static_cast<std::ptrdiff_t>(y) * measured.width();
  for (int x = 0; x < measured.width(); ++x) {
    const auto column = static_cast<float>(x);
    const float z = row[x];
    const float p_x = (first.x() + along.x() * column) * z + t.x();
    const float p_y = (first.y() + along.y() * column) * z + t.y();
    const float p_z = (first.z() + along.z() * column) * z + t.z();
    const float per_z = 1 / p_z;
    places.u[x] = fx * p_x * per_z + cx;
    places.v[x] = fy * p_y * per_z + cy;
    places.z[x] = z > 0 ? p_z : -1.0f;
  }
}

ColorLookup::View ColorLookup::view() const {
  View view;
  view.R_color_depth = R_color_depth_;
  view.t_color_depth = t_color_depth_;
  view.focal_px = Eigen::Vector2d{camera_.fx, camera_.fy}.cast<float>();
  view.centre_px = Eigen::Vector2d{camera_.cx, camera_.cy}.cast<float>();
  view.scale = scale_;
  view.columns = nearest_.width();
  view.rows = nearest_.height();
  view.step_per_m = step_per_m_;
  view.nearest = nearest_.data();
  view.color = color_->data();
  view.width = color_->width();
  view.height = color_->height();
  return view;
}

inline Rgb8 ColorLookup::View::bilinear(float u, float v) const {
  constexpr auto kPerPixel = static_cast<int>(kUnit);
  const int u_units = static_cast<int>(std::clamp(u, 0.0f, static_cast<float>(width - 1)) * kPerPixel + 0.5f);
  const int v_units = static_cast<int>(std::clamp(v, 0.0f, static_cast<float>(height - 1)) * kPerPixel + 0.5f);
  const int x = std::min(u_units / kPerPixel, width - 2);
  const int y = std::min(v_units / kPerPixel, height - 2);
  const auto fx = static_cast<std::uint64_t>(u_units - x * kPerPixel);
  const auto fy = static_cast<std::uint64_t>(v_units - y * kPerPixel);
  const Rgb8* p = color + static_cast<std::ptrdiff_t>(y) * width + x;
  const Rgb8* q = p + width;
  const std::uint64_t top = lanes(p[0]) * (kUnit - fx) + lanes(p[1]) * fx;
  const std::uint64_t bottom = lanes(q[0]) * (kUnit - fx) + lanes(q[1]) * fx;
  return rounded(top * (kUnit - fy) + bottom * fy);
}

inline std::optional<Eigen::Vector2f> ColorLookup::View::seen_at(const Eigen::Vector3f& p_depth, float sigma_m) const {
  const Eigen::Vector3f p = R_color_depth * p_depth + t_color_depth;
  if (columns == 0 || !(p.z() > 0.01f)) return std::nullopt;
  const float per_z = 1 / p.z();
  const float u = focal_px.x() * p.x() * per_z + centre_px.x();
  const float v = focal_px.y() * p.y() * per_z + centre_px.y();
  if (!(u >= -0.5f && v >= -0.5f && u <= static_cast<float>(width) - 0.5f && v <= static_cast<float>(height) - 0.5f))
    return std::nullopt;
  const auto cell_x = std::min(static_cast<int>(std::max(u * scale + 0.5f, 0.0f)), columns - 1);
  const auto cell_y = std::min(static_cast<int>(std::max(v * scale + 0.5f, 0.0f)), rows - 1);
  if (p.z() > nearest[cell_y * columns + cell_x] + 3 * sigma_m + p.z() * step_per_m) return std::nullopt;
  return Eigen::Vector2f{u, v};
}

std::optional<Rgb8> ColorLookup::texel_of(const Eigen::Vector3f& p_depth, float sigma_m) const {
  const auto pixel = view().seen_at(p_depth, sigma_m);
  if (!pixel) return std::nullopt;
  return cubic(*color_, *pixel);
}

std::optional<Rgb8> ColorLookup::color_of(const Eigen::Vector3f& p_depth, float sigma_m) const {
  const auto view = this->view();
  const auto pixel = view.seen_at(p_depth, sigma_m);
  if (!pixel) return std::nullopt;
  return view.bilinear(pixel->x(), pixel->y());
}

ColorsOfPoints ColorLookup::colors_of(std::span<const Eigen::Vector3f> points_depth,
                                      std::span<const float> sigmas_m) const {
  ColorsOfPoints found{std::vector<Rgb8>(points_depth.size()), std::vector<std::uint8_t>(points_depth.size(), 0)};
  const View view = this->view();
  Rgb8* colors = found.colors.data();
  std::uint8_t* seen = found.seen.data();
  for (std::size_t i = 0; i < points_depth.size(); ++i) {
    const auto pixel = view.seen_at(points_depth[i], sigmas_m[i]);
    if (!pixel) continue;
    colors[i] = view.bilinear(pixel->x(), pixel->y());
    seen[i] = 1;
  }
  return found;
}

}  // namespace meshloop::adjust
