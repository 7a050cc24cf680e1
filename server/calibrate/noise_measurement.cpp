#include "server/calibrate/noise_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/median.h"

namespace meshloop {
namespace {

// Nguyen 2012: the Kinect's. Used where the scene shows too few depth edges to measure it.
constexpr double kUsualLateral_px = 0.8;
constexpr std::size_t kLeastBinPixels = 300;
// Of variance over half the mean squared step, in the median over the pixels. Noise of 20 frames gives 1.00 +- 0.15 at
// a single pixel.
constexpr double kMostRatio = 1.5;

double step_of(const std::vector<NoiseBin>& bins) {
  double sum = 0;
  double weight = 0;
  for (const NoiseBin& bin : bins) {
    const auto pixels = static_cast<double>(bin.pixels);
    sum += pixels * bin.step_m / (bin.z_m * bin.z_m);
    weight += pixels;
  }
  return weight > 0 ? sum / weight : 0;
}

double median_ratio(const Image<noise::PixelNoise>& pixels, const Image<std::uint8_t>& use) {
  std::vector<float> ratios;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto& pixel = pixels.data()[i];
    if (use.data()[i] != 0 && pixel.step_variance_m2 > 0) {
      ratios.push_back(pixel.variance_m2 / pixel.step_variance_m2);
    }
  }
  if (ratios.empty()) return 1;
  return static_cast<double>(median(std::move(ratios)));
}

}  // namespace

Status NoiseMeasurement::add(const DepthImage& measured) {
  if (measured.width() != camera_.width || measured.height() != camera_.height) {
    return fail(fmt::format("the depth image has {}x{} pixels, but its camera {}x{}", measured.width(),
                            measured.height(), camera_.width, camera_.height));
  }
  if (count() == kMostFrames) return fail(fmt::format("the noise is measured from at most {} frames", kMostFrames));
  frames_.push_back(measured);
  return {};
}

Result<MeasuredNoise> NoiseMeasurement::fit() const {
  if (count() < kLeastFrames) {
    return fail(fmt::format("the noise of {} frames cannot be measured; record at least {} of a scene at rest", count(),
                            kLeastFrames));
  }
  const auto pixels = noise::over_time(frames_);
  const auto use = noise::smooth_surface(pixels, camera_);
  const double ratio = median_ratio(pixels, use);
  if (ratio > kMostRatio) {
    return fail(
        fmt::format("the camera or the scene moved: depths vary {:.1f} times as much over the recording as "
                    "from frame to frame; record a scene at rest, from a tripod",
                    std::sqrt(ratio)));
  }
  MeasuredNoise result;
  result.bins = noise::bins_of(pixels, use, frames_);
  std::erase_if(result.bins, [](const NoiseBin& bin) { return bin.pixels < kLeastBinPixels; });
  if (result.bins.empty()) {
    return fail("too little smooth surface is measured in all frames; point the camera at walls or a floor");
  }
  SensorNoise figures;
  figures.axial = noise::fit_polynomial(result.bins);
  figures.nearest_m = result.bins.front().z_m;
  figures.farthest_m = result.bins.back().z_m;
  figures.step_per_m = step_of(result.bins);
  const auto lateral = noise::lateral_noise(pixels, frames_);
  result.edges = lateral.edges;
  figures.lateral_px = lateral.edges >= kLeastEdges ? lateral.sigma_px : kUsualLateral_px;
  auto model = SensorModel::measured(figures);
  if (!model) return fail("the fit to the measured noise", model.error());
  result.model = std::move(*model);
  for (const NoiseBin& bin : result.bins) {
    result.worst_fit = std::max(result.worst_fit, std::abs(result.model.sigma_z_m(bin.z_m, 0) / bin.sigma_m - 1));
  }
  return result;
}

}  // namespace meshloop
