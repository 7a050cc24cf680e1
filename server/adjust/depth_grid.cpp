#include "server/adjust/depth_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "common/base/target_clones.h"

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

// Where a depth is the mean of several measurements its noise is less.
void use_means(DepthGrid& grid, const Image<std::uint8_t>& measurements, const SensorModel& sensor) {
  std::size_t members = 0;
  double inverse_counts = 0;
  const int w = grid.window.width();
  for (std::size_t i = 0; i < grid.z.size(); ++i) {
    if (grid.role[i] == Role::outside) continue;
    const int x = static_cast<int>(i) % w + grid.window.x0;
    const int y = static_cast<int>(i) / w + grid.window.y0;
    const int count = std::max<int>(measurements(x, y), 1);
    if (count > 1) grid.sigma[i] = static_cast<float>(std::sqrt(sensor.variance_m2(grid.z[i], 0, count)));
    if (grid.role[i] != Role::member) continue;
    ++members;
    inverse_counts += 1.0 / count;
  }
  if (members > 0) grid.lateral_px *= std::sqrt(inverse_counts / static_cast<double>(members));
}

void set_noise(DepthGrid& grid, const Image<std::uint8_t>& measurements, const SensorModel& sensor) {
  sensor.frontal_sigmas_m(grid.z, grid.sigma);
  for (std::size_t i = 0; i < grid.sigma.size(); ++i)
    grid.sigma[i] = grid.role[i] == Role::outside ? 0.0f : grid.sigma[i];
  grid.lateral_px = sensor.sigma_lateral_px(0);
  if (!measurements.empty()) use_means(grid, measurements, sensor);
}

constexpr int kRadius = 2;
constexpr float kCut_sigmas = 5;
// The window with kRadius more pixels to each side, 0 outside the image.
std::vector<float> padded_copy(const DepthImage& measured, const Window& window) {
  const int w = window.width() + 2 * kRadius;
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
constexpr std::size_t kWidth = 2 * kRadius + 1;
using RowWeights = std::array<float, kWidth>;

std::array<RowWeights, kWidth> spatial_weights() {
  constexpr float kSigma_px = 1.2f;
  std::array<RowWeights, kWidth> weights{};
  for (std::size_t y = 0; y < kWidth; ++y) {
    for (std::size_t x = 0; x < kWidth; ++x) {
      const auto dx = static_cast<float>(x) - kRadius;
      const auto dy = static_cast<float>(y) - kRadius;
      weights[y][x] = std::exp(-(dx * dx + dy * dy) / (2 * kSigma_px * kSigma_px));
    }
  }
  return weights;
}

/// Of one row of pixels: their depths, what the weights fall by, and the sums over the pixels around.
struct SmoothedRow {
  std::vector<float> z;
  std::vector<float> per_cut2;
  std::vector<float> shift;
  std::vector<float> weight;

  explicit SmoothedRow(std::size_t width) : z(width), per_cut2(width), shift(width), weight(width) {}
};

MESHLOOP_TARGET_CLONES
void begin_row(SmoothedRow& row, const float* z, const float* sigma) {
  for (std::size_t x = 0; x < row.z.size(); ++x) {
    const float cut = kCut_sigmas * sigma[x];
    row.z[x] = z[x];
    row.per_cut2[x] = 1 / (cut * cut + 1e-12f);
    row.shift[x] = 0;
    row.weight[x] = 0;
  }
}

// One of the rows around. `around` begins kRadius pixels to the left. Tukey's weight: smooth, and 0 from kCut_sigmas
// on; a missing measurement (0) is far beyond.
MESHLOOP_TARGET_CLONES
void add_row(SmoothedRow& row, const float* around, const RowWeights& weights) {
  const RowWeights w = weights;
  const float* z = row.z.data();
  const float* per_cut2 = row.per_cut2.data();
  float* shift = row.shift.data();
  float* weight = row.weight.data();
  const std::size_t count = row.z.size();
  for (std::size_t x = 0; x < count; ++x) {
    float shifts = shift[x];
    float sum = weight[x];
    for (std::size_t k = 0; k < kWidth; ++k) {
      const float d = around[x + k] - z[x];
      const float near = std::max(1 - d * d * per_cut2[x], 0.0f);
      const float share = w[k] * near * near;
      shifts += share * d;
      sum += share;
    }
    shift[x] = shifts;
    weight[x] = sum;
  }
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
  const auto w = static_cast<std::size_t>(grid.window.width());
  const auto source = padded_copy(measured, grid.window);
  const auto weights = spatial_weights();
  SmoothedRow row{w};
  for (std::size_t y = 0; y < static_cast<std::size_t>(grid.window.height()); ++y) {
    float* z = grid.z.data() + y * w;
    const Role* role = grid.role.data() + y * w;
    begin_row(row, z, grid.sigma.data() + y * w);
    for (std::size_t k = 0; k < kWidth; ++k) add_row(row, source.data() + (y + k) * (w + 2 * kRadius), weights[k]);
    for (std::size_t x = 0; x < w; ++x) {
      const float shift = row.weight[x] > 0 ? row.shift[x] / row.weight[x] : 0.0f;
      z[x] = role[x] == Role::member ? z[x] + shift : z[x];
    }
  }
}

}  // namespace meshloop::adjust
