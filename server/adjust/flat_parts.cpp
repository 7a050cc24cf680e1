#include "server/adjust/flat_parts.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/base/target_clones.h"

namespace meshloop::adjust {
namespace {

constexpr int kBlock_px = 8;
/// Of a block's pixels so many must be members.
constexpr int kLeastPixels = kBlock_px * kBlock_px * 3 / 4;
/// A block's mean lies on a plane within so many sigma of one measurement.
constexpr double kOnPlane_sigmas = 0.5;
/// The measurements of a block on a plane spread by at most so many sigma (root mean square).
constexpr double kSpread_sigmas = 1.4;
constexpr std::size_t kLeastBlocks = 4;
/// A single measurement is put onto a plane when it lies within so many sigma of it.
constexpr double kSnap_sigmas = 3;

/// Standard deviation of one divided by the depth, measured on a plane: of the depth itself, and of the place in the
/// picture, which counts on a slant.
double sigma_on(const PicturePlane& plane, double inverse_sigma, double lateral_px) {
  const double lateral2 = plane.per_column * plane.per_column + plane.per_row * plane.per_row;
  return std::sqrt(inverse_sigma * inverse_sigma + lateral_px * lateral_px * lateral2);
}

/// Sums over measurements of one column of the picture, each with its weight: of 1, y, y^2, v, y v and v^2, where v is
/// one divided by the depth; and how many there are.
struct ColumnSums {
  double weight = 0;
  double y = 0;
  double yy = 0;
  double v = 0;
  double yv = 0;
  double vv = 0;
  int count = 0;
};

/// The same for several columns, each number in a row of its own.
struct RowOfColumnSums {
  std::vector<double> weight;
  std::vector<double> y;
  std::vector<double> yy;
  std::vector<double> v;
  std::vector<double> yv;
  std::vector<double> vv;
  std::vector<int> count;

  explicit RowOfColumnSums(std::size_t width)
      : weight(width), y(width), yy(width), v(width), yv(width), vv(width), count(width) {}
  void clear() {
    for (auto* values : {&weight, &y, &yy, &v, &yv, &vv}) std::fill(values->begin(), values->end(), 0.0);
    std::fill(count.begin(), count.end(), 0);
  }
  [[nodiscard]] ColumnSums at(std::size_t x) const { return {weight[x], y[x], yy[x], v[x], yv[x], vv[x], count[x]}; }
};

/// A row of the window.
struct GridRow {
  const float* z;
  const float* sigma;
  const Role* role;
};

bool is_measured_member(Role role, float sigma) {
  return role == Role::member && sigma > 0;
}

// One divided by the depth has sigma / z^2.
ColumnSums sums_of(double y, float z, float sigma) {
  const double v = 1 / static_cast<double>(z);
  const double inverse_sigma = static_cast<double>(sigma) * v * v;
  const double weight = 1 / (inverse_sigma * inverse_sigma);
  return {weight, weight * y, weight * y * y, weight * v, weight * v * y, weight * v * v, 1};
}

MESHLOOP_TARGET_CLONES
void add_row(RowOfColumnSums& sums, const GridRow& row, double y) {
  const GridRow r = row;
  const std::size_t width = sums.weight.size();
  double* sum_w = sums.weight.data();
  double* sum_y = sums.y.data();
  double* sum_yy = sums.yy.data();
  double* sum_v = sums.v.data();
  double* sum_yv = sums.yv.data();
  double* sum_vv = sums.vv.data();
  int* count = sums.count.data();
  for (std::size_t x = 0; x < width; ++x) {
    const bool counts = (r.role[x] == Role::member) & (r.sigma[x] > 0);
    const float z = counts ? r.z[x] : 1.0f;
    const float sigma = counts ? r.sigma[x] : 1.0f;
    const double v = 1 / static_cast<double>(z);
    const double inverse_sigma = static_cast<double>(sigma) * v * v;
    const double weight = (counts ? 1.0 : 0.0) / (inverse_sigma * inverse_sigma);
    sum_w[x] += weight;
    sum_y[x] += weight * y;
    sum_yy[x] += weight * y * y;
    sum_v[x] += weight * v;
    sum_yv[x] += weight * v * y;
    sum_vv[x] += weight * v * v;
    count[x] += counts ? 1 : 0;
  }
}

/// Sums for fitting 1 / z = a x + b y + c with the weights of the measurements, residuals in sigma.
class Sums {
 public:
  void add(double x, const ColumnSums& column) {
    const double wx = x * column.weight;
    A_ +=
        Eigen::Matrix3d{{x * wx, x * column.y, wx}, {x * column.y, column.yy, column.y}, {wx, column.y, column.weight}};
    b_ += Eigen::Vector3d{x * column.v, column.yv, column.v};
    square_ += column.vv;
    count_ += column.count;
  }
  void add(const Sums& other) {
    A_ += other.A_;
    b_ += other.b_;
    square_ += other.square_;
    count_ += other.count_;
  }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] PicturePlane fit() const {
    const Eigen::Vector3d p = A_.ldlt().solve(b_);
    return {p[0], p[1], p[2]};
  }
  /// Mean residual and root mean square of the residuals, in sigma.
  struct Residual {
    double mean = 0;
    double rms = 0;
  };
  [[nodiscard]] Residual residual(const PicturePlane& plane, double lateral_px) const {
    const Eigen::Vector3d p{plane.per_column, plane.per_row, plane.at_corner};
    const double weight = A_(2, 2);
    if (count_ == 0 || !(weight > 0)) return {};
    const Eigen::Vector3d Ap = A_ * p;
    const double square = square_ - 2 * p.dot(b_) + p.dot(Ap);
    // The weights are one divided by sigma squared.
    const double sigma = sigma_on(plane, std::sqrt(count_ / weight), lateral_px);
    return {(b_[2] - Ap[2]) / weight / sigma, std::sqrt(std::max(square, 0.0) / weight) / sigma};
  }

 private:
  Eigen::Matrix3d A_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b_ = Eigen::Vector3d::Zero();
  double square_ = 0;
  int count_ = 0;
};

class FlatPartFinder {
 public:
  explicit FlatPartFinder(const DepthGrid& grid)
      : grid_{grid},
        width_{grid.window.width()},
        height_{grid.window.height()},
        columns_{(width_ + kBlock_px - 1) / kBlock_px},
        rows_{(height_ + kBlock_px - 1) / kBlock_px},
        blocks_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
        plane_of_block_(blocks_.size(), 0) {
    sum_blocks();
  }

  FlatParts find() {
    FlatParts parts;
    parts.plane_of_pixel.assign(grid_.z.size(), 0);
    for (const auto seed : seeds()) {
      if (plane_of_block_[seed] == 0) grow(seed, parts.planes);
    }
    if (parts.planes.empty()) return parts;
    find_sides(parts.planes);
    assign_pixels(parts);
    refit(parts);
    return parts;
  }

 private:
  [[nodiscard]] std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::size_t block_of(int x, int y) const {
    return static_cast<std::size_t>(y / kBlock_px) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(x / kBlock_px);
  }
  [[nodiscard]] bool is_member(std::size_t i) const { return is_measured_member(grid_.role[i], grid_.sigma[i]); }
  [[nodiscard]] double inverse_sigma(std::size_t i) const {
    const auto z = static_cast<double>(grid_.z[i]);
    return static_cast<double>(grid_.sigma[i]) / (z * z);
  }

  void sum_blocks() {
    const auto w = static_cast<std::size_t>(width_);
    RowOfColumnSums columns{w};
    for (int y0 = 0; y0 < height_; y0 += kBlock_px) {
      columns.clear();
      for (int y = y0; y < std::min(y0 + kBlock_px, height_); ++y) {
        const auto i = pixel(0, y);
        add_row(columns, {grid_.z.data() + i, grid_.sigma.data() + i, grid_.role.data() + i}, y);
      }
      Sums* blocks = blocks_.data() + block_of(0, y0);
      for (std::size_t x = 0; x < w; ++x) blocks[x / kBlock_px].add(static_cast<double>(x), columns.at(x));
    }
  }

  /// Blocks that are flat by themselves, the flattest first.
  [[nodiscard]] std::vector<std::size_t> seeds() const {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (blocks_[b].count() < kLeastPixels) continue;
      const double rms = blocks_[b].residual(blocks_[b].fit(), grid_.lateral_px).rms;
      if (rms <= kSpread_sigmas) order.emplace_back(rms, b);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::size_t> blocks;
    for (const auto& [rms, b] : order) blocks.push_back(b);
    return blocks;
  }

  [[nodiscard]] bool is_on(std::size_t block, const PicturePlane& plane) const {
    if (blocks_[block].count() < kLeastPixels) return false;
    const auto residual = blocks_[block].residual(plane, grid_.lateral_px);
    return std::abs(residual.mean) <= kOnPlane_sigmas && residual.rms <= kSpread_sigmas;
  }

  template <typename Visit>
  void for_neighbours(std::size_t block, const Visit& visit) const {
    const int bx = static_cast<int>(block) % columns_;
    const int by = static_cast<int>(block) / columns_;
    for (int ny = std::max(by - 1, 0); ny <= std::min(by + 1, rows_ - 1); ++ny) {
      for (int nx = std::max(bx - 1, 0); nx <= std::min(bx + 1, columns_ - 1); ++nx) {
        const auto next =
            static_cast<std::size_t>(ny) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(nx);
        if (next != block) visit(next);
      }
    }
  }

  /// Rings around the seed; the plane is fitted anew after each, and blocks that are no longer on it leave.
  void grow(std::size_t seed, std::vector<PicturePlane>& planes) {
    if (planes.size() == std::numeric_limits<std::uint16_t>::max() - 1) return;
    const auto number = static_cast<std::uint16_t>(planes.size() + 1);
    std::vector<std::size_t> blocks{seed};
    plane_of_block_[seed] = number;
    PicturePlane plane = blocks_[seed].fit();
    for (bool grown = true; grown;) {
      grown = add_ring(blocks, plane, number);
      plane = fit(blocks);
      std::erase_if(blocks, [&](std::size_t b) {
        const bool leaves = b != seed && !is_on(b, plane);
        if (leaves) plane_of_block_[b] = kLeft;
        return leaves;
      });
    }
    for (auto& p : plane_of_block_) {
      if (p == kLeft) p = 0;
    }
    if (blocks.size() >= kLeastBlocks) {
      planes.push_back(plane);
    } else {
      for (const auto b : blocks) plane_of_block_[b] = 0;
    }
  }
  bool add_ring(std::vector<std::size_t>& blocks, const PicturePlane& plane, std::uint16_t number) {
    const std::size_t before = blocks.size();
    for (std::size_t i = 0; i < before; ++i) {
      for_neighbours(blocks[i], [&](std::size_t next) {
        if (plane_of_block_[next] != 0 || !is_on(next, plane)) return;
        plane_of_block_[next] = number;
        blocks.push_back(next);
      });
    }
    return blocks.size() > before;
  }
  [[nodiscard]] PicturePlane fit(const std::vector<std::size_t>& blocks) const {
    Sums sums;
    for (const auto b : blocks) sums.add(blocks_[b]);
    return sums.fit();
  }

  /// Of two planes that meet, each lies on one side of the line in which they do: which of them is the nearer one
  /// there, by the blocks that are surely on it.
  void find_sides(const std::vector<PicturePlane>& planes) {
    const std::size_t n = planes.size();
    nearer_votes_.assign(n * n, 0);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (plane_of_block_[b] == 0) continue;
      const std::size_t own = plane_of_block_[b] - 1u;
      const double x = (static_cast<double>(b % static_cast<std::size_t>(columns_)) + 0.5) * kBlock_px;
      const double y = (static_cast<double>(b / static_cast<std::size_t>(columns_)) + 0.5) * kBlock_px;
      for (std::size_t other = 0; other < n; ++other) {
        nearer_votes_[own * n + other] += planes[own].at(x, y) > planes[other].at(x, y) ? 1 : -1;
      }
    }
  }
  /// Is a pixel on a's side of the line in which the two meet, by the side on which more of a's blocks lie?
  [[nodiscard]] bool is_on_side_of(std::size_t a, std::size_t b, const std::vector<PicturePlane>& planes, double x,
                                   double y) const {
    const std::size_t n = planes.size();
    const bool a_is_nearer = planes[a].at(x, y) > planes[b].at(x, y);
    return a_is_nearer == (nearer_votes_[a * n + b] > 0);
  }

  void assign_pixels(FlatParts& parts) const {
    std::vector<std::uint16_t> candidates;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      candidates.clear();
      if (plane_of_block_[b] != 0) candidates.push_back(plane_of_block_[b]);
      for_neighbours(b, [&](std::size_t next) {
        const auto plane = plane_of_block_[next];
        if (plane != 0 && std::find(candidates.begin(), candidates.end(), plane) == candidates.end()) {
          candidates.push_back(plane);
        }
      });
      if (!candidates.empty()) assign_block(b, candidates, parts);
    }
  }
  void assign_block(std::size_t block, const std::vector<std::uint16_t>& candidates, FlatParts& parts) const {
    const int x0 = static_cast<int>(block) % columns_ * kBlock_px;
    const int y0 = static_cast<int>(block) / columns_ * kBlock_px;
    for (int y = y0; y < std::min(y0 + kBlock_px, height_); ++y) {
      for (int x = x0; x < std::min(x0 + kBlock_px, width_); ++x) {
        const auto i = pixel(x, y);
        if (is_member(i)) parts.plane_of_pixel[i] = best_plane(x, y, candidates, parts.planes);
      }
    }
  }
  [[nodiscard]] std::uint16_t best_plane(int x, int y, const std::vector<std::uint16_t>& candidates,
                                         const std::vector<PicturePlane>& planes) const {
    const auto i = pixel(x, y);
    const double inverse_z = 1 / static_cast<double>(grid_.z[i]);
    std::uint16_t best = 0;
    double best_sigmas = kSnap_sigmas;
    for (const auto candidate : candidates) {
      const PicturePlane& plane = planes[candidate - 1u];
      const double sigmas = std::abs(inverse_z - plane.at(x, y)) / sigma_on(plane, inverse_sigma(i), grid_.lateral_px);
      if (sigmas > kSnap_sigmas) continue;
      const bool is_better = best == 0 ||
                             (is_on_side_of(candidate - 1u, best - 1u, planes, x, y) &&
                              !is_on_side_of(best - 1u, candidate - 1u, planes, x, y)) ||
                             (is_on_side_of(candidate - 1u, best - 1u, planes, x, y) ==
                                  is_on_side_of(best - 1u, candidate - 1u, planes, x, y) &&
                              sigmas < best_sigmas);
      if (is_better) {
        best = candidate;
        best_sigmas = sigmas;
      }
    }
    return best;
  }

  void refit(FlatParts& parts) const {
    std::vector<Sums> sums(parts.planes.size());
    for (int by = 0; by < rows_; ++by) {
      for (int bx = 0; bx < columns_; ++bx) add_block(bx * kBlock_px, by * kBlock_px, parts, sums);
    }
    for (std::size_t p = 0; p < sums.size(); ++p) {
      if (sums[p].count() >= kLeastPixels) parts.planes[p] = sums[p].fit();
    }
  }
  /// Of a block all of whose members are on one plane the sums are known.
  void add_block(int x0, int y0, const FlatParts& parts, std::vector<Sums>& sums) const {
    const Sums& whole = blocks_[block_of(x0, y0)];
    const auto plane = plane_of_block_[block_of(x0, y0)];
    int on_plane = 0;
    const auto for_planes = [&](const auto& visit) {
      for (int y = y0; y < std::min(y0 + kBlock_px, height_); ++y) {
        for (int x = x0; x < std::min(x0 + kBlock_px, width_); ++x) visit(x, y, parts.plane_of_pixel[pixel(x, y)]);
      }
    };
    for_planes([&](int, int, std::uint16_t p) { on_plane += p == plane && p != 0 ? 1 : 0; });
    if (plane != 0 && on_plane == whole.count()) {
      sums[plane - 1u].add(whole);
      return;
    }
    for_planes([&](int x, int y, std::uint16_t p) {
      if (p != 0) sums[p - 1u].add(x, sums_of(y, grid_.z[pixel(x, y)], grid_.sigma[pixel(x, y)]));
    });
  }

  static constexpr std::uint16_t kLeft = std::numeric_limits<std::uint16_t>::max();

  const DepthGrid& grid_;
  int width_;
  int height_;
  int columns_;
  int rows_;
  std::vector<Sums> blocks_;
  std::vector<std::uint16_t> plane_of_block_;
  std::vector<int> nearer_votes_;
};

}  // namespace

FlatParts find_flat_parts(const DepthGrid& grid) {
  if (grid.window.empty()) return {{}, std::vector<std::uint16_t>(grid.z.size(), 0)};
  return FlatPartFinder{grid}.find();
}

namespace {

/// Of the eight around a pixel, the plane that seven of them are on; else 0.
std::uint16_t plane_around(const FlatParts& parts, std::size_t i, std::size_t w) {
  constexpr int kMost = 7;
  const std::array<std::size_t, 8> around{i - w - 1, i - w, i - w + 1, i - 1, i + 1, i + w - 1, i + w, i + w + 1};
  for (std::size_t k = 0; k + kMost <= around.size(); ++k) {
    const auto plane = parts.plane_of_pixel[around[k]];
    const auto same =
        std::count_if(around.begin(), around.end(), [&](std::size_t j) { return parts.plane_of_pixel[j] == plane; });
    if (plane != 0 && same >= kMost) return plane;
  }
  return 0;
}

}  // namespace

void fill_gaps(DepthGrid& grid, FlatParts& parts, const DepthImage& measured) {
  constexpr int kRounds = 2;
  const int w = grid.window.width();
  std::vector<std::pair<std::size_t, std::uint16_t>> filled;
  for (int round = 0; round < kRounds; ++round) {
    filled.clear();
    for (int y = 1; y + 1 < grid.window.height(); ++y) {
      for (int x = 1; x + 1 < w; ++x) {
        const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
        if (grid.role[i] != Role::outside || measured(x + grid.window.x0, y + grid.window.y0) > 0) continue;
        const auto plane = plane_around(parts, i, static_cast<std::size_t>(w));
        if (plane != 0) filled.emplace_back(i, plane);
      }
    }
    for (const auto& [i, plane] : filled) {
      parts.plane_of_pixel[i] = plane;
      grid.role[i] = Role::gap;
      const auto columns = static_cast<std::size_t>(w);
      for (const auto j : {i - 1, i + 1, i - columns, i + columns}) {
        if (parts.plane_of_pixel[j] == plane && grid.sigma[j] > 0) grid.sigma[i] = grid.sigma[j];
      }
    }
  }
}

void snap_to_planes(DepthGrid& grid, const FlatParts& parts) {
  const auto w = static_cast<std::size_t>(grid.window.width());
  for (std::size_t i = 0; i < grid.z.size(); ++i) {
    const auto plane = parts.plane_of_pixel[i];
    if (plane == 0) continue;
    const float z = parts.planes[plane - 1u].depth(static_cast<double>(i % w), static_cast<double>(i / w));
    if (z > 0) grid.z[i] = z;
  }
}

}  // namespace meshloop::adjust
