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
constexpr std::uint64_t kUnit = kUnitsPerPixel;

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

/// Of the pixel `p` and those to its right and below; the numbers of units to the right and down.
Rgb8 bilinear(const Rgb8* p, int width, std::int32_t right_units, std::int32_t down_units) {
  const auto right = static_cast<std::uint64_t>(right_units);
  const auto down = static_cast<std::uint64_t>(down_units);
  const Rgb8* q = p + width;
  const std::uint64_t top = lanes(p[0]) * (kUnit - right) + lanes(p[1]) * right;
  const std::uint64_t bottom = lanes(q[0]) * (kUnit - right) + lanes(q[1]) * right;
  return rounded(top * (kUnit - down) + bottom * down);
}

}  // namespace

ColorLookup::ColorLookup(const Snapshot& snapshot) : color_{&snapshot.frame->color} {
  const Camera& color = snapshot.rig->color;
  const Camera& depth = snapshot.rig->depth;
  const Pose T_color_depth = snapshot.rig->T_depth_color.inverse();
  view_.R_color_depth = T_color_depth.linear().cast<float>();
  view_.t_color_depth = T_color_depth.translation().cast<float>();
  view_.fx = static_cast<float>(color.fx);
  view_.fy = static_cast<float>(color.fy);
  view_.cx = static_cast<float>(color.cx);
  view_.cy = static_cast<float>(color.cy);
  view_.width = color.width;
  view_.height = color.height;
  if (color_->width() != color.width || color_->height() != color.height || color.width < 2 || color.height < 2) return;
  view_.scale = static_cast<float>(std::min(1.0, depth.fx / color.fx));
  view_.columns = static_cast<int>(std::ceil(static_cast<float>(color.width) * view_.scale)) + 1;
  view_.rows = static_cast<int>(std::ceil(static_cast<float>(color.height) * view_.scale)) + 1;
  step_per_m_ = static_cast<float>(2 * kSteepest / std::min(depth.fx, depth.fy));
  draw(snapshot.frame->depth, depth);
}

void ColorLookup::draw(const DepthImage& measured, const Camera& depth) {
  const int w = view_.columns;
  nearest_ = DepthImage{w, view_.rows, kNothing};
  const auto end_u = static_cast<float>(w - 1);
  const auto end_v = static_cast<float>(view_.rows - 1);
  const auto columns = static_cast<std::size_t>(measured.width());
  std::vector<float> u(columns);
  std::vector<float> v(columns);
  std::vector<float> z(columns);
  const Eigen::Vector3f along = view_.R_color_depth.col(0) * static_cast<float>(1 / depth.fx);
  for (int y = 0; y < measured.height(); ++y) {
    const Eigen::Vector3f first =
        view_.R_color_depth * Eigen::Vector3f{0, static_cast<float>((y - depth.cy) / depth.fy), 1} -
        along * static_cast<float>(depth.cx);
    const float* row = measured.data() + static_cast<std::ptrdiff_t>(y) * measured.width();
    project_row(view_, first, along, row, columns, {u.data(), v.data(), z.data()});
    for (std::size_t x = 0; x < columns; ++x) {
      if (!(z[x] > 0.01f && u[x] >= 0 && v[x] >= 0 && u[x] < end_u && v[x] < end_v)) continue;
      float* cell = nearest_.data() + static_cast<std::ptrdiff_t>(v[x]) * w + static_cast<std::ptrdiff_t>(u[x]);
      cell[0] = std::min(cell[0], z[x]);
      cell[1] = std::min(cell[1], z[x]);
      cell[w] = std::min(cell[w], z[x]);
      cell[w + 1] = std::min(cell[w + 1], z[x]);
    }
  }
}

void ColorLookup::look(std::span<const Eigen::Vector3f> points_depth, std::span<const float> sigmas_m,
                       ProjectedPoints& projected, std::uint8_t* seen) const {
  project_points(view_, points_depth.data(), points_depth.size(), projected);
  const float* nearest = nearest_.data();
  const float step_per_m = step_per_m_;
  for (std::size_t i = 0; i < points_depth.size(); ++i) {
    const float z = projected.z[i];
    const bool is_hidden = z > nearest[projected.cell[i]] + 3 * sigmas_m[i] + z * step_per_m;
    seen[i] = static_cast<std::uint8_t>(projected.inside[i] != 0 && !is_hidden);
  }
}

std::optional<Eigen::Vector2f> ColorLookup::seen_at(const Eigen::Vector3f& p_depth, float sigma_m) const {
  if (nearest_.empty()) return std::nullopt;
  ProjectedPoints projected;
  std::uint8_t seen = 0;
  look({&p_depth, 1}, {&sigma_m, 1}, projected, &seen);
  if (seen == 0) return std::nullopt;
  return Eigen::Vector2f{projected.u[0], projected.v[0]};
}

std::optional<Rgb8> ColorLookup::texel_of(const Eigen::Vector3f& p_depth, float sigma_m) const {
  const auto pixel = seen_at(p_depth, sigma_m);
  if (!pixel) return std::nullopt;
  return cubic(*color_, *pixel);
}

std::optional<Rgb8> ColorLookup::color_of(const Eigen::Vector3f& p_depth, float sigma_m) const {
  const auto found = colors_of({&p_depth, 1}, {&sigma_m, 1});
  if (found.seen.front() == 0) return std::nullopt;
  return found.colors.front();
}

ColorsOfPoints ColorLookup::colors_of(std::span<const Eigen::Vector3f> points_depth,
                                      std::span<const float> sigmas_m) const {
  ColorsOfPoints found{std::vector<Rgb8>(points_depth.size()), std::vector<std::uint8_t>(points_depth.size(), 0)};
  if (nearest_.empty()) return found;
  const Rgb8* pixels = color_->data();
  const int width = view_.width;
  ProjectedPoints projected;
  PixelCorners corners;
  for (std::size_t begin = 0; begin < points_depth.size(); begin += kPointsAtOnce) {
    const std::size_t count = std::min(kPointsAtOnce, points_depth.size() - begin);
    Rgb8* colors = found.colors.data() + begin;
    std::uint8_t* seen = found.seen.data() + begin;
    look(points_depth.subspan(begin, count), sigmas_m.subspan(begin, count), projected, seen);
    find_corners(view_, projected, count, corners);
    for (std::size_t i = 0; i < count; ++i) {
      if (seen[i] == 0) continue;
      colors[i] = bilinear(pixels + corners.top_left[i], width, corners.right_units[i], corners.down_units[i]);
    }
  }
  return found;
}

}  // namespace meshloop::adjust
