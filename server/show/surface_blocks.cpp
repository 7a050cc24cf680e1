#include "server/show/surface_blocks.h"

#include <algorithm>
#include <cmath>

namespace meshloop::show {
namespace {

constexpr int kLargestBlock = 8;
constexpr double kSteepest = 5.671281819617709;  // tan(80 degrees)
// Two measurements of one surface differ by less than this many sigma of one of them.
constexpr double kNoiseSigmas = 5.7;  // 4 sqrt(2)
constexpr double kFlatSigmas = 4;
constexpr float kFarthest_m = 50;
constexpr float kNearest_m = 0.02f;
// So far from any inverse depth that nothing is joined to it.
constexpr float kNothing = -1e6f;

/// What the rules allow at a depth, looked up: the sensor's formula for each pixel would cost more than the rest.
class Limits {
 public:
  explicit Limits(const BlockRules& rules) {
    const double slope = kSteepest / std::min(rules.camera.fx, rules.camera.fy);
    for (std::size_t i = 0; i < kBins; ++i) {
      const double z = (static_cast<double>(i) + 0.5) / kBinsPerMetre;
      const double noise = rules.sensor.sigma_z_m(z, 0) / (z * z);
      const double step = slope / z + kNoiseSigmas * noise;
      step_[i] = static_cast<float>(step);
      flat_[i] = static_cast<float>(std::min(step, std::max<double>(rules.flatness_per_m, kFlatSigmas * noise)));
    }
  }
  [[nodiscard]] float step(float z) const { return step_[bin(z)]; }
  [[nodiscard]] float flat(float z) const { return flat_[bin(z)]; }

 private:
  static constexpr std::size_t kBins = 2048;
  static constexpr float kBinsPerMetre = static_cast<float>(kBins) / kFarthest_m;
  static std::size_t bin(float z) { return std::min(static_cast<std::size_t>(z * kBinsPerMetre), kBins - 1); }

  std::array<float, kBins> step_{};
  std::array<float, kBins> flat_{};
};

class BlockMaker {
 public:
  BlockMaker(const DepthImage& depth, const BlockRules& rules)
      : limits_{rules},
        width_{depth.width()},
        height_{depth.height()},
        stride_{depth.width() + 2},
        inverse_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(depth.height() + 2), kNothing) {
    for (int y = 0; y < height_; ++y) {
      const float* from = depth.data() + static_cast<std::ptrdiff_t>(y) * width_;
      std::transform(from, from + width_, row(y),
                     [](float z) { return z >= kNearest_m && z <= kFarthest_m ? 1 / z : kNothing; });
    }
  }

  std::vector<Block> make() {
    for (int y = 0; y < height_; y += kLargestBlock) {
      for (int x = 0; x < width_; x += kLargestBlock) cover(x, y, kLargestBlock);
    }
    return std::move(blocks_);
  }

 private:
  [[nodiscard]] float* row(int y) { return inverse_.data() + static_cast<std::ptrdiff_t>(y + 1) * stride_ + 1; }
  [[nodiscard]] const float* row(int y) const {
    return inverse_.data() + static_cast<std::ptrdiff_t>(y + 1) * stride_ + 1;
  }

  void cover(int x, int y, int size) {
    if (x >= width_ || y >= height_ || is_empty(x, y, size)) return;
    const Block block = block_at(x, y, size);
    if (size == 1 || is_flat(block)) {
      blocks_.push_back(block);
      return;
    }
    const int half = size / 2;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {half, 0}, {0, half}, {half, half}}) cover(x + dx, y + dy, half);
  }

  [[nodiscard]] bool is_empty(int x, int y, int size) const {
    const int columns = std::min(size, width_ - x);
    for (int v = y; v < std::min(y + size, height_); ++v) {
      int measured = 0;
      for (int u = 0; u < columns; ++u) measured += row(v)[x + u] > 0 ? 1 : 0;
      if (measured > 0) return false;
    }
    return true;
  }

  // Of a block with a corner outside the image or without a depth, that corner is kNothing.
  [[nodiscard]] Block block_at(int x, int y, int size) const {
    const int right = x + size - 1;
    const int bottom = y + size - 1;
    return {x,
            y,
            size,
            {corner(x, y, -1, -1), corner(right, y, 1, -1), corner(x, bottom, -1, 1), corner(right, bottom, 1, 1)}};
  }

  // The mean over those of the four pixels around a corner of pixel (u, v) that lie on its surface.
  [[nodiscard]] float corner(int u, int v, int right, int down) const {
    if (u >= width_ || v >= height_) return kNothing;
    const float own = row(v)[u];
    if (!(own > 0)) return kNothing;
    const float step = limits_.step(1 / own);
    float sum = own;
    float count = 1;
    for (const float other : {row(v)[u + right], row(v + down)[u], row(v + down)[u + right]}) {
      if (std::abs(other - own) > step) continue;
      sum += other;
      ++count;
    }
    return sum / count;
  }

  [[nodiscard]] bool is_flat(const Block& block) const {
    const auto& [a, b, c, d] = block.inverse_depth;
    const float lowest = std::min({a, b, c, d});
    if (!(lowest > 0)) return false;
    const float z = 1 / lowest;
    const auto size = static_cast<float>(block.size);
    const float step = size * limits_.step(z);
    if (std::max({a, b, c, d}) - lowest > 2 * step || std::abs(a - b) > step || std::abs(c - d) > step ||
        std::abs(a - c) > step || std::abs(b - d) > step) {
      return false;
    }
    const float flat = limits_.flat(z);
    if (std::abs(a + d - b - c) > 2 * flat) return false;  // drawn as two triangles, it would have a ridge
    for (int v = 0; v < block.size; ++v) {
      const float down = (static_cast<float>(v) + 0.5f) / size;
      const float left = a + (c - a) * down;
      const float across = (b + (d - b) * down - left) / size;
      const float* q = row(block.y + v) + block.x;
      int outside = 0;
      for (int u = 0; u < block.size; ++u) {
        outside += std::abs(q[u] - left - across * (static_cast<float>(u) + 0.5f)) > flat ? 1 : 0;
      }
      if (outside > 0) return false;
    }
    return true;
  }

  Limits limits_;
  int width_;
  int height_;
  int stride_;
  /// With a border of one pixel around the image.
  std::vector<float> inverse_;
  std::vector<Block> blocks_;
};

}  // namespace

std::vector<Block> make_blocks(const DepthImage& depth, const BlockRules& rules) {
  return BlockMaker{depth, rules}.make();
}

}  // namespace meshloop::show
