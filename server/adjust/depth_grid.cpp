#include "server/adjust/depth_grid.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace meshloop::adjust {
namespace {

// Neither NaN nor infinite: one such neighbour would spoil a mean.
bool is_depth(float z) {
  return z > 0 && z < 1000;
}

bool touches_member(const DepthGrid& grid, int x, int y) {
  const int w = grid.window.width();
  const int h = grid.window.height();
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, h - 1); ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, w - 1); ++nx) {
      if (grid.role[static_cast<std::size_t>(ny) * static_cast<std::size_t>(w) + static_cast<std::size_t>(nx)] ==
          Role::member) {
        return true;
      }
    }
  }
  return false;
}

void mark_members(DepthGrid& grid, const Comparison& comparison, const DepthImage& measured, const Image<RegionId>& ids,
                  RegionId region) {
  std::size_t i = 0;
  for (int y = grid.window.y0; y < grid.window.y1; ++y) {
    for (int x = grid.window.x0; x < grid.window.x1; ++x, ++i) {
      const float z = measured(x, y);
      if (ids(x, y) != region || kind_of(comparison.labels(x, y)) != ChangeKind::insertion || !is_depth(z)) continue;
      grid.role[i] = Role::member;
      grid.z[i] = z;
    }
  }
}

// A rim pixel that agrees is put onto the model's surface, where the patch is to meet it.
void mark_rim(DepthGrid& grid, const Comparison& comparison, const DepthImage& measured) {
  std::size_t i = 0;
  for (int y = 0; y < grid.window.height(); ++y) {
    for (int x = 0; x < grid.window.width(); ++x, ++i) {
      if (grid.role[i] != Role::outside || !touches_member(grid, x, y)) continue;
      const int u = x + grid.window.x0;
      const int v = y + grid.window.y0;
      const Label label = comparison.labels(u, v);
      if (label != Label::agrees && label != Label::undecided) continue;
      const float z = label == Label::agrees ? comparison.expected(u, v) : measured(u, v);
      if (!is_depth(z)) continue;
      grid.role[i] = label == Label::agrees ? Role::model_rim : Role::rim;
      grid.z[i] = z;
    }
  }
}

/// Standard deviation of a depth of so many measurements, frontal view, in metres.
float sigma_of_mean_m(const SensorModel& sensor, float z, int measurements) {
  const auto depth = static_cast<double>(z);
  if (measurements <= 1) return static_cast<float>(sensor.sigma_z_m(depth, 0));
  return static_cast<float>(std::sqrt(sensor.variance_m2(depth, 0, measurements)));
}

void set_noise(DepthGrid& grid, const Image<std::uint8_t>& measurements, const SensorModel& sensor) {
  std::size_t members = 0;
  double inverse_counts = 0;
  const int w = grid.window.width();
  for (std::size_t i = 0; i < grid.z.size(); ++i) {
    if (grid.role[i] == Role::outside) continue;
    const int x = static_cast<int>(i) % w + grid.window.x0;
    const int y = static_cast<int>(i) / w + grid.window.y0;
    const int count = measurements.empty() ? 1 : std::max<int>(measurements(x, y), 1);
    grid.sigma[i] = sigma_of_mean_m(sensor, grid.z[i], count);
    if (grid.role[i] != Role::member) continue;
    ++members;
    inverse_counts += 1.0 / count;
  }
  const double share = members == 0 ? 1 : inverse_counts / static_cast<double>(members);
  grid.lateral_px = sensor.sigma_lateral_px(0) * std::sqrt(share);
}

constexpr int kRadius = 2;
constexpr float kCut_sigmas = 5;
/// So many pixels of a row are smoothed at once: their sums stay in registers.
constexpr int kAtOnce = 8;
using Few = Eigen::Array<float, kAtOnce, 1>;

// Whole steps of kAtOnce, so that the last ones of a row have something to read too.
int padded_width(const Window& window) {
  return (window.width() + kAtOnce - 1) / kAtOnce * kAtOnce + 2 * kRadius;
}

// The window with kRadius more pixels to each side, 0 outside the image.
std::vector<float> padded_copy(const DepthImage& measured, const Window& window) {
  const int w = padded_width(window);
  std::vector<float> copy(static_cast<std::size_t>(w) * static_cast<std::size_t>(window.height() + 2 * kRadius), 0.0f);
  const int first = std::max(window.x0 - kRadius, 0);
  const int last = std::min(window.x1 + kRadius, measured.width());
  for (int y = std::max(window.y0 - kRadius, 0); y < std::min(window.y1 + kRadius, measured.height()); ++y) {
    float* row = copy.data() + static_cast<std::ptrdiff_t>(y - window.y0 + kRadius) * w;
    std::transform(&measured(first, y), &measured(first, y) + (last - first), row + (first - window.x0 + kRadius),
                   [](float z) { return is_depth(z) ? z : 0.0f; });
  }
  return copy;
}

/// Weights of the pixels of the 5x5 window, by row.
std::array<float, 25> spatial_weights() {
  constexpr float kSigma_px = 1.2f;
  std::array<float, 25> weights{};
  for (int i = 0; i < 25; ++i) {
    const int dx = i % 5 - kRadius;
    const int dy = i / 5 - kRadius;
    weights[static_cast<std::size_t>(i)] =
        std::exp(-static_cast<float>(dx * dx + dy * dy) / (2 * kSigma_px * kSigma_px));
  }
  return weights;
}

// By how much a few pixels are too near. `source` is the top left of the first one's window. Tukey's weight: smooth,
// and 0 from kCut_sigmas on; a missing measurement (0) is far beyond.
Few mean_shift(const float* source, std::ptrdiff_t stride, const std::array<float, 25>& weights, const Few& z,
               const Few& per_cut2) {
  Few shift = Few::Zero();
  Few weight = Few::Zero();
  for (std::ptrdiff_t i = 0; i < 25; ++i) {
    const Few d = Eigen::Map<const Few>(source + i / 5 * stride + i % 5) - z;
    const Few share = weights[static_cast<std::size_t>(i)] * (1 - d.square() * per_cut2).max(0.0f).square();
    shift += share * d;
    weight += share;
  }
  return (weight > 0).select(shift / weight, 0.0f);
}

}  // namespace

Window window_of(const Image<RegionId>& ids, RegionId region) {
  Window box{ids.width(), ids.height(), 0, 0};
  for (int y = 0; y < ids.height(); ++y) {
    const RegionId* row = ids.data() + static_cast<std::ptrdiff_t>(y) * ids.width();
    const auto* first = std::find(row, row + ids.width(), region);
    if (first == row + ids.width()) continue;
    int last = ids.width() - 1;
    while (row[last] != region) --last;
    box.x0 = std::min(box.x0, static_cast<int>(first - row));
    box.x1 = std::max(box.x1, last + 1);
    box.y0 = std::min(box.y0, y);
    box.y1 = y + 1;
  }
  if (box.empty()) return {};
  return {std::max(box.x0 - 1, 0), std::max(box.y0 - 1, 0), std::min(box.x1 + 1, ids.width()),
          std::min(box.y1 + 1, ids.height())};
}

DepthGrid select_patch(const Comparison& comparison, const DepthImage& measured,
                       const Image<std::uint8_t>& measurements, const Image<RegionId>& ids, RegionId region,
                       const SensorModel& sensor) {
  DepthGrid grid;
  grid.window = window_of(ids, region);
  const std::size_t size = grid.window.size();
  grid.z.assign(size, 0.0f);
  grid.sigma.assign(size, 0.0f);
  grid.role.assign(size, Role::outside);
  mark_members(grid, comparison, measured, ids, region);
  mark_rim(grid, comparison, measured);
  set_noise(grid, measurements, sensor);
  return grid;
}

void smooth(DepthGrid& grid, const DepthImage& measured) {
  const int w = grid.window.width();
  const int stride = padded_width(grid.window);
  const auto source = padded_copy(measured, grid.window);
  const auto weights = spatial_weights();
  for (int y = 0; y < grid.window.height(); ++y) {
    for (int x = 0; x < w; x += kAtOnce) {
      const int first = y * w + x;
      const int count = std::min(kAtOnce, w - x);
      Few z = Few::Zero();
      Few sigma = Few::Zero();
      std::copy_n(grid.z.data() + first, count, z.data());
      std::copy_n(grid.sigma.data() + first, count, sigma.data());
      const Few per_cut2 = 1 / ((kCut_sigmas * sigma).square() + 1e-12f);
      z += mean_shift(source.data() + static_cast<std::ptrdiff_t>(y) * stride + x, stride, weights, z, per_cut2);
      for (int k = 0; k < count; ++k) {
        const auto i = static_cast<std::size_t>(first + k);
        if (grid.role[i] == Role::member) grid.z[i] = z[k];
      }
    }
  }
}

}  // namespace meshloop::adjust
