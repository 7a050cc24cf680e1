#include "server/adjust/depth_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "common/base/connected.h"

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

float spatial_weight(int dx, int dy) {
  constexpr float kSigma_px = 1.2f;
  return std::exp(-static_cast<float>(dx * dx + dy * dy) / (2 * kSigma_px * kSigma_px));
}

/// The edges of a 2x2 block of pixels that lie on one surface.
struct Steps {
  float across;   // per metre of depth, to the next column
  float down;     // to the next row
  float slanted;  // to the next of both
  float sigmas;
};

struct Corner {
  float z;
  float sigma;
  std::uint16_t line;
};

/// They lie on one straight line; a corner, of which there is one among several lines, lies on each of them.
bool on_one_line(const Corner& a, const Corner& b) {
  return a.line != 0 && b.line != 0 && (a.line == b.line || a.line == kCornerOfLines || b.line == kCornerOfLines);
}

bool joined(const Corner& a, const Corner& b, float step, float sigmas) {
  if (a.z <= 0 || b.z <= 0) return false;
  const Corner& nearer = a.z < b.z ? a : b;
  return std::abs(a.z - b.z) <= nearer.z * step + sigmas * nearer.sigma;
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
  const int padded_w = w + 2 * kRadius;
  const auto source = padded_copy(measured, grid.window);
  const auto columns = static_cast<std::size_t>(w);
  std::vector<float> shift(columns);
  std::vector<float> weight(columns);
  std::vector<float> per_cut2(columns);
  for (int y = 0; y < grid.window.height(); ++y) {
    float* z = grid.z.data() + static_cast<std::ptrdiff_t>(y) * w;
    const float* sigma = grid.sigma.data() + static_cast<std::ptrdiff_t>(y) * w;
    for (std::size_t x = 0; x < columns; ++x)
      per_cut2[x] = 1.0f / (kCut_sigmas * kCut_sigmas * sigma[x] * sigma[x] + 1e-12f);
    std::fill(shift.begin(), shift.end(), 0.0f);
    std::fill(weight.begin(), weight.end(), 0.0f);
    for (int dy = 0; dy <= 2 * kRadius; ++dy) {
      for (int dx = 0; dx <= 2 * kRadius; ++dx) {
        const float near = spatial_weight(dx - kRadius, dy - kRadius);
        const float* other = source.data() + static_cast<std::ptrdiff_t>(y + dy) * padded_w + dx;
        for (std::size_t x = 0; x < columns; ++x) {
          const float d = other[x] - z[x];
          // Tukey's weight: smooth, and 0 from kCut_sigmas on; a missing measurement (0) is far beyond.
          const float inside = std::max(0.0f, 1 - d * d * per_cut2[x]);
          const float share = near * inside * inside;
          shift[x] += share * d;
          weight[x] += share;
        }
      }
    }
    const Role* role = grid.role.data() + static_cast<std::ptrdiff_t>(y) * w;
    for (std::size_t x = 0; x < columns; ++x) {
      if (role[x] == Role::member && weight[x] > 0) z[x] += shift[x] / weight[x];
    }
  }
}

namespace {

// Up to two triangles of the block whose corners are 0 (top left), 1 (top right), 2 (bottom left), 3 (bottom right).
void triangulate_block(const std::array<Corner, 4>& c, const std::array<std::uint32_t, 4>& index, const Steps& steps,
                       std::vector<Triangle>& triangles) {
  const bool top = joined(c[0], c[1], steps.across, steps.sigmas);
  const bool bottom = joined(c[2], c[3], steps.across, steps.sigmas);
  const bool left = joined(c[0], c[2], steps.down, steps.sigmas);
  const bool right = joined(c[1], c[3], steps.down, steps.sigmas);
  const bool falling = joined(c[0], c[3], steps.slanted, steps.sigmas);
  const bool rising = joined(c[1], c[2], steps.slanted, steps.sigmas);
  const auto both = [](bool diagonal, bool first, bool second) {
    return diagonal ? static_cast<int>(first) + static_cast<int>(second) : 0;
  };
  const int along_falling = both(falling, left && bottom, top && right);
  const int along_rising = both(rising, top && left, bottom && right);
  const bool flatter_falls = std::abs(c[0].z - c[3].z) <= std::abs(c[1].z - c[2].z);
  const bool line_falls = on_one_line(c[0], c[3]);
  const bool line_rises = on_one_line(c[1], c[2]);
  const bool better_falls = line_falls != line_rises ? line_falls : flatter_falls;
  if (along_falling > along_rising || (along_falling == along_rising && better_falls)) {
    if (falling && left && bottom) triangles.push_back({index[0], index[2], index[3]});
    if (falling && top && right) triangles.push_back({index[0], index[3], index[1]});
  } else {
    if (rising && top && left) triangles.push_back({index[0], index[2], index[1]});
    if (rising && bottom && right) triangles.push_back({index[1], index[2], index[3]});
  }
}

}  // namespace

std::vector<Triangle> triangulate(const DepthGrid& grid, const Camera& camera, double discontinuity_sigmas,
                                  const std::vector<std::uint16_t>& lines) {
  const Steps steps{static_cast<float>(kSteepest / camera.fx), static_cast<float>(kSteepest / camera.fy),
                    static_cast<float>(kSteepest * std::hypot(1 / camera.fx, 1 / camera.fy)),
                    static_cast<float>(discontinuity_sigmas)};
  std::vector<Triangle> all;
  all.reserve(2 * grid.z.size());
  const auto w = static_cast<std::uint32_t>(std::max(grid.window.width(), 0));
  for (int y = 0; y + 1 < grid.window.height(); ++y) {
    for (std::uint32_t x = 0; x + 1 < w; ++x) {
      const std::uint32_t first = static_cast<std::uint32_t>(y) * w + x;
      const std::array<std::uint32_t, 4> index{first, first + 1, first + w, first + w + 1};
      std::array<Corner, 4> corners;
      int corners_there = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        corners[i] = {grid.z[index[i]], grid.sigma[index[i]], lines.empty() ? std::uint16_t{0} : lines[index[i]]};
        corners_there += corners[i].z > 0 ? 1 : 0;
      }
      if (corners_there >= 3) triangulate_block(corners, index, steps, all);
    }
  }
  const auto only_rim = [&](const Triangle& t) {
    return std::none_of(t.begin(), t.end(), [&](std::uint32_t i) { return is_part(grid.role[i]); });
  };
  all.erase(std::remove_if(all.begin(), all.end(), only_rim), all.end());
  return all;
}

void drop_small_pieces(std::vector<Triangle>& triangles, std::size_t vertex_count, std::size_t smallest) {
  Connected connected{vertex_count};
  for (const auto& [a, b, c] : triangles) {
    connected.join(a, b);
    connected.join(b, c);
  }
  std::vector<std::uint32_t> count(vertex_count, 0);
  for (const auto& t : triangles) ++count[connected.first_of(t[0])];
  std::erase_if(triangles, [&](const Triangle& t) { return count[connected.first_of(t[0])] < smallest; });
}

}  // namespace meshloop::adjust
