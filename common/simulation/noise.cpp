// What a depth sensor and a colour camera make of exact images.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/simulation/random.h"
#include "common/simulation/sensor.h"

namespace meshloop::simulation {
namespace {

constexpr double kNearest_m = 0.4;
constexpr double kFarthest_m = 4.5;
constexpr double kLargestAngle = 80 * std::numbers::pi / 180;
// The Kinect's projector, to the right of its infrared camera.
constexpr double kProjectorBaseline_m = 0.075;
// A surface counts as hidden from the projector when another one is nearer by this much; less moves the dots by
// less than a pixel at 1.2 m.
constexpr double kShadowStep_m = 0.03;
// A step in depth between neighbours (share of the depth) at which the pattern of dots tears.
constexpr double kTear = 0.025;
constexpr double kTornShare = 0.3;

enum Stream : std::uint64_t { kLateral = 1, kAxial = 2, kDropout = 3 };

bool is_kinect(const SensorModel& sensor) {
  return sensor.kind() == SensorModel::Kind::kinect1 || sensor.kind() == SensorModel::Kind::kinect1_khoshelham;
}

// A row of the picture seen from the projector: for each of its columns the nearest depth. Camera and projector share
// their rows, so that a shadow falls along them.
class ProjectorRow {
 public:
  ProjectorRow(const DepthImage& depth, const Camera& camera, int v)
      : shift_{camera.fx * kProjectorBaseline_m},
        columns_{camera.width + static_cast<int>(shift_ / kNearest_m) + 2},
        nearest_(static_cast<std::size_t>(columns_), std::numeric_limits<double>::infinity()) {
    for (int u = 0; u < depth.width(); ++u) {
      const double z = depth(u, v);
      if (z < kNearest_m) continue;
      const double previous = u > 0 ? depth(u - 1, v) : 0.0;
      // Between two pixels of one surface the projector may see more than one column.
      const bool joined = std::abs(previous - z) < kShadowStep_m;
      fill(joined ? column(u - 1, previous) : column(u, z), column(u, z), z);
    }
  }

  [[nodiscard]] bool hides(int u, double z) const {
    const double seen = nearest_[index_of(column(u, z))];
    return seen < z - kShadowStep_m;
  }

 private:
  [[nodiscard]] double column(int u, double z) const { return u - shift_ / z + shift_ / kNearest_m; }
  [[nodiscard]] std::size_t index_of(double column) const {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(std::lround(column)), 0, columns_ - 1));
  }
  void fill(double from, double to, double z) {
    const std::size_t last = index_of(std::max(from, to));
    for (std::size_t i = index_of(std::min(from, to)); i <= last; ++i) nearest_[i] = std::min(nearest_[i], z);
  }

  double shift_;
  int columns_;
  std::vector<double> nearest_;
};

// Pixels at which the sensor can measure at all; 0 elsewhere.
DepthImage measurable(const ExactDepth& exact, const Camera& camera, const SensorModel& sensor) {
  DepthImage depth = exact.depth;
  const auto smallest_cos = static_cast<float>(std::cos(kLargestAngle));
  for (int v = 0; v < depth.height(); ++v) {
    const ProjectorRow projector(exact.depth, camera, v);
    for (int u = 0; u < depth.width(); ++u) {
      float& z = depth(u, v);
      if (z == 0) continue;
      const bool hidden = is_kinect(sensor) && projector.hides(u, z);
      if (hidden || exact.cos_theta(u, v) < smallest_cos) z = 0;
    }
  }
  return depth;
}

bool is_torn(const DepthImage& depth, int u, int v) {
  const double z = depth(u, v);
  const auto steps = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= depth.width() || y >= depth.height()) return false;
    return std::abs(depth(x, y) - z) > kTear * z;
  };
  return steps(u - 1, v) || steps(u + 1, v) || steps(u, v - 1) || steps(u, v + 1);
}

// Steps of z^2 in depth are equal steps of its inverse, the disparity.
double quantised(double z, double disparity_step) {
  if (disparity_step <= 0) return z;
  return 1 / (std::max(1.0, std::round(1 / (z * disparity_step))) * disparity_step);
}

/// One frame of a noisy sensor, pixel by pixel.
class NoisyFrame {
 public:
  NoisyFrame(const ExactDepth& exact, const Camera& camera, const SensorModel& sensor, const NoiseOptions& options)
      : exact_{exact}, sensor_{sensor}, options_{options}, source_{measurable(exact, camera, sensor)} {}

  [[nodiscard]] float at(int u, int v) const {
    const auto index = static_cast<std::uint64_t>(v) * static_cast<std::uint64_t>(exact_.depth.width()) +
                       static_cast<std::uint64_t>(u);
    const auto [x, y] = source_pixel(u, v, index);
    const double z = source_(x, y);
    if (z == 0) return 0;
    if (is_kinect(sensor_) && is_torn(exact_.depth, u, v) &&
        random_unit(options_.seed, index, kDropout) < kTornShare * std::min(1.0, options_.strength)) {
      return 0;
    }
    const double measured = disturbed(z, theta(x, y), index);
    return measured >= kNearest_m && measured <= kFarthest_m ? static_cast<float>(measured) : 0.0f;
  }

 private:
  [[nodiscard]] double theta(int u, int v) const {
    return std::acos(std::clamp(static_cast<double>(exact_.cos_theta(u, v)), 0.0, 1.0));
  }

  // Lateral noise moves silhouettes. Inside a surface the axial sigma already holds everything that was observed on
  // tilted planes (Nguyen 2012, figure 5), so there the pixel keeps its own depth.
  [[nodiscard]] std::pair<int, int> source_pixel(int u, int v, std::uint64_t index) const {
    const double angle = exact_.solid(u, v) == 0 ? 0.0 : theta(u, v);
    const double sigma = sensor_.sigma_lateral_px(angle) * options_.strength;
    if (sigma <= 0) return {u, v};
    const auto [du, dv] = random_normals(options_.seed, index, kLateral);
    const int x = std::clamp(static_cast<int>(std::lround(u + sigma * du)), 0, source_.width() - 1);
    const int y = std::clamp(static_cast<int>(std::lround(v + sigma * dv)), 0, source_.height() - 1);
    if (exact_.solid(x, y) == exact_.solid(u, v)) return {u, v};
    return {x, y};
  }

  [[nodiscard]] double disturbed(double z, double angle, std::uint64_t index) const {
    const double sigma = sensor_.sigma_z_m(z, angle) * options_.strength;
    const double step = sensor_.quantisation_m(z) * options_.strength;
    // Rounding to steps adds step^2 / 12 to the variance.
    const double gaussian = std::sqrt(std::max(0.0, sigma * sigma - step * step / 12));
    return quantised(z + gaussian * random_normals(options_.seed, index, kAxial).first, step / (z * z));
  }

  const ExactDepth& exact_;
  const SensorModel& sensor_;
  const NoiseOptions& options_;
  DepthImage source_;
};

// Whole grey levels with the normal distribution, as a table over 16 random bits.
std::vector<std::int8_t> normal_table(double sigma) {
  constexpr std::size_t kEntries = 1 << 16;
  std::vector<std::int8_t> table;
  table.reserve(kEntries);
  for (int level = -127; level <= 127; ++level) {
    const double below = 0.5 * std::erfc(-(level + 0.5) / (sigma * std::numbers::sqrt2));
    const auto end = static_cast<std::size_t>(std::lround(below * kEntries));
    if (end > table.size()) table.resize(end, static_cast<std::int8_t>(level));
  }
  table.resize(kEntries, 127);
  return table;
}

std::uint8_t shifted(std::uint8_t channel, int levels) {
  return static_cast<std::uint8_t>(std::clamp(channel + levels, 0, 255));
}

}  // namespace

DepthImage measure(const ExactDepth& exact, const Camera& camera, const SensorModel& sensor,
                   const NoiseOptions& options) {
  DepthImage measured = exact.depth;
  if (options.strength <= 0) {
    for (float& z : measured.pixels()) {
      if (z < kNearest_m || z > kFarthest_m) z = 0;
    }
    return measured;
  }
  const NoisyFrame frame(exact, camera, sensor, options);
  for (int v = 0; v < measured.height(); ++v) {
    for (int u = 0; u < measured.width(); ++u) measured(u, v) = frame.at(u, v);
  }
  return measured;
}

void add_color_noise(ColorImage& image, double sigma, std::uint64_t seed) {
  if (!(sigma > 0)) return;
  const auto table = normal_table(sigma);
  std::uint64_t index = 0;
  for (Rgb8& pixel : image.pixels()) {
    const std::uint64_t bits = random_bits(seed, index++);
    pixel.r = shifted(pixel.r, table[bits & 0xffff]);
    pixel.g = shifted(pixel.g, table[(bits >> 16) & 0xffff]);
    pixel.b = shifted(pixel.b, table[(bits >> 32) & 0xffff]);
  }
}

}  // namespace meshloop::simulation
