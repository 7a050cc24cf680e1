#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "common/base/median.h"

#include "server/calibrate/noise_measurement.h"

namespace meshloop::noise {
namespace {

constexpr float kMeasuredShare = 0.8F;
// A Kinect's pattern tears at edges; in the shadow of its projector only stray measurements are left.
constexpr float kSeenAtEdge = 0.5F;
// Of the depth: a greater step to a neighbour is an edge.
constexpr float kEdge = 0.025F;
constexpr int kFromEdge_px = 3;
constexpr double kSteepest = std::numbers::pi / 3;
constexpr double kBinRatio = 1.08;
// Bins of 8 % need this range of depths for a slope, and for a curve.
constexpr double kRangeOfSlope = 1.25;
constexpr double kRangeOfCurve = 1.8;
// Beside an edge, pixels to each side; beyond the third a Kinect is wrong in less than one of a thousand.
constexpr int kBesideEdge_px = 3;

bool is_depth(float z) {
  return z > 0 && z < 1e6F;
}

bool is_edge(float a, float b) {
  return a <= 0 || b <= 0 || std::abs(a - b) > kEdge * std::min(a, b);
}

int bin_number(double z_m) {
  return static_cast<int>(std::floor(std::log(z_m) / std::log(kBinRatio)));
}

// The median distance of the depths that were delivered, from one to the next.
double step_of(std::vector<float> depths) {
  std::sort(depths.begin(), depths.end());
  std::vector<float> gaps;
  for (std::size_t i = 1; i < depths.size(); ++i) {
    if (depths[i] > depths[i - 1]) gaps.push_back(depths[i] - depths[i - 1]);
  }
  if (gaps.size() < 2) return 0;
  return static_cast<double>(median(std::move(gaps)));
}

// Where a depth edge lies between the pixels u and u + 1: the depth in the middle between its two sides, which are
// looked at a little away from it, where they are not mixed.
std::optional<float> edge_after(const Image<PixelNoise>& pixels, int u, int v) {
  const auto mean = [&](int x) { return pixels(x, v).mean_m; };
  const auto is_seen = [&](int x) { return pixels(x, v).measured_share > kSeenAtEdge; };
  const float left = mean(u - kBesideEdge_px);
  const float right = mean(u + 1 + kBesideEdge_px);
  if (left <= 0 || right <= 0 || !is_edge(left, right) || !is_edge(mean(u), mean(u + 1))) return std::nullopt;
  if (is_edge(left, mean(u - kBesideEdge_px - 1)) || is_edge(right, mean(u + 2 + kBesideEdge_px))) return std::nullopt;
  const float middle = 0.5F * (left + right);
  for (int i = 0; i <= kBesideEdge_px; ++i) {
    const bool left_fits = is_seen(u - i) && (mean(u - i) < middle) == (left < middle);
    const bool right_fits = is_seen(u + 1 + i) && (mean(u + 1 + i) < middle) == (right < middle);
    if (!left_fits || !right_fits) return std::nullopt;
  }
  return middle;
}

// Of a pixel's measurements: how many see the surface beyond the edge.
double other_side_share(const std::vector<DepthImage>& frames, float middle, int u, int v, bool is_nearer) {
  int measured = 0;
  int other = 0;
  for (const DepthImage& frame : frames) {
    if (!is_depth(frame(u, v))) continue;
    ++measured;
    other += (frame(u, v) < middle) != is_nearer ? 1 : 0;
  }
  return measured > 0 ? static_cast<double>(other) / measured : 0;
}

bool is_smooth_around(const Image<PixelNoise>& pixels, int u, int v) {
  for (int y = v - kFromEdge_px; y <= v + kFromEdge_px; ++y) {
    for (int x = u - kFromEdge_px; x <= u + kFromEdge_px; ++x) {
      if (pixels(x, y).measured_share < kMeasuredShare) return false;
      if (x > u - kFromEdge_px && is_edge(pixels(x, y).mean_m, pixels(x - 1, y).mean_m)) return false;
      if (y > v - kFromEdge_px && is_edge(pixels(x, y).mean_m, pixels(x, y - 1).mean_m)) return false;
    }
  }
  return true;
}

// Cosine of the angle between the ray and the surface's normal. Inverse depth is linear on a plane: its slopes give the
// normal (server/compare/README.md).
double viewing_cosine(const Image<PixelNoise>& pixels, const Camera& camera, int u, int v) {
  constexpr int kReach = kFromEdge_px;
  const auto inverse = [&](int x, int y) { return 1 / static_cast<double>(pixels(x, y).mean_m); };
  const double by_u = camera.fx * (inverse(u + kReach, v) - inverse(u - kReach, v)) / (2 * kReach);
  const double by_v = camera.fy * (inverse(u, v + kReach) - inverse(u, v - kReach)) / (2 * kReach);
  const Eigen::Vector3d ray = camera.back_project(u, v, 1);
  const Eigen::Vector3d normal{by_u, by_v, inverse(u, v) - ray.x() * by_u - ray.y() * by_v};
  return inverse(u, v) / (normal.norm() * ray.norm());
}

}  // namespace

Image<PixelNoise> over_time(const std::vector<DepthImage>& frames) {
  Image<PixelNoise> pixels(frames.front().width(), frames.front().height());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    double mean = 0;
    double squares = 0;
    double steps = 0;
    double last = 0;
    int count = 0;
    for (const DepthImage& frame : frames) {
      if (!is_depth(frame.data()[i])) continue;
      const auto z = static_cast<double>(frame.data()[i]);
      const double from_mean = z - mean;
      mean += from_mean / ++count;
      squares += from_mean * (z - mean);
      if (count > 1) steps += (z - last) * (z - last);
      last = z;
    }
    if (count < 2) continue;
    pixels.data()[i] = {static_cast<float>(mean), static_cast<float>(squares / (count - 1)),
                        static_cast<float>(steps / (2 * (count - 1))),
                        static_cast<float>(count) / static_cast<float>(frames.size())};
  }
  return pixels;
}

Image<std::uint8_t> smooth_surface(const Image<PixelNoise>& pixels, const Camera& camera) {
  Image<std::uint8_t> use(pixels.width(), pixels.height());
  for (int v = kFromEdge_px; v < pixels.height() - kFromEdge_px; ++v) {
    for (int u = kFromEdge_px; u < pixels.width() - kFromEdge_px; ++u) {
      const bool is_used = is_smooth_around(pixels, u, v) && viewing_cosine(pixels, camera, u, v) > std::cos(kSteepest);
      use(u, v) = is_used ? 1 : 0;
    }
  }
  return use;
}

std::vector<NoiseBin> bins_of(const Image<PixelNoise>& pixels, const Image<std::uint8_t>& use,
                              const std::vector<DepthImage>& frames) {
  struct Sums {
    NoiseBin bin;
    double variance = 0;
    std::vector<float> depths;
  };
  std::map<int, Sums> sums;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (use.data()[i] == 0) continue;
    const PixelNoise& pixel = pixels.data()[i];
    Sums& sum = sums[bin_number(static_cast<double>(pixel.mean_m))];
    ++sum.bin.pixels;
    sum.bin.z_m += static_cast<double>(pixel.mean_m);
    sum.variance += static_cast<double>(pixel.variance_m2);
    if (is_depth(frames.front().data()[i])) sum.depths.push_back(frames.front().data()[i]);
  }
  std::vector<NoiseBin> bins;
  for (auto& [number, sum] : sums) {
    const auto pixels_in_bin = static_cast<double>(sum.bin.pixels);
    sum.bin.z_m /= pixels_in_bin;
    sum.bin.step_m = step_of(std::move(sum.depths));
    sum.bin.sigma_m = std::sqrt(std::max(sum.variance / pixels_in_bin, sum.bin.step_m * sum.bin.step_m / 12));
    // No noise and no steps: a clipped or made-up depth, which tells nothing.
    if (sum.bin.sigma_m > 0) bins.push_back(sum.bin);
  }
  return bins;
}

Eigen::Vector3d fit_polynomial(const std::vector<NoiseBin>& bins) {
  const double range = bins.back().z_m / bins.front().z_m;
  const int terms = range > kRangeOfCurve && bins.size() > 3 ? 3 : range > kRangeOfSlope && bins.size() > 2 ? 2 : 1;
  Eigen::MatrixXd A(bins.size(), terms);
  for (std::size_t i = 0; i < bins.size(); ++i) {
    // Relative deviations: each row is divided by its own sigma.
    double power = 1;
    for (int term = 0; term < terms; ++term) {
      A(static_cast<Eigen::Index>(i), term) = power / bins[i].sigma_m;
      power *= bins[i].z_m;
    }
  }
  Eigen::Vector3d coefficients = Eigen::Vector3d::Zero();
  coefficients.head(terms) = A.colPivHouseholderQr().solve(Eigen::VectorXd::Ones(A.rows()));
  return coefficients;
}

LateralNoise lateral_noise(const Image<PixelNoise>& pixels, const std::vector<DepthImage>& frames) {
  LateralNoise result;
  double other_side = 0;
  for (int v = 0; v < pixels.height(); ++v) {
    for (int u = kBesideEdge_px + 1; u + kBesideEdge_px + 2 < pixels.width(); ++u) {
      const auto edge = edge_after(pixels, u, v);
      if (!edge) continue;
      ++result.edges;
      for (int x = u - kBesideEdge_px; x <= u + 1 + kBesideEdge_px; ++x) {
        other_side += other_side_share(frames, *edge, x, v, pixels(x, v).mean_m < *edge);
      }
    }
  }
  // Two sides to each edge.
  const double a_side = result.edges > 0 ? other_side / (2 * static_cast<double>(result.edges)) : 0;
  result.sigma_px = std::sqrt(2 * std::numbers::pi) * a_side;
  return result;
}

}  // namespace meshloop::noise
