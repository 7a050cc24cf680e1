#pragma once
// A sensor's noise, measured from a scene at rest.
#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/camera.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop {

/// What was seen at one depth.
struct NoiseBin {
  /// Mean depth of the bin's pixels, metres.
  double z_m = 0;
  /// Standard deviation over time, root mean square over the pixels, metres.
  double sigma_m = 0;
  /// Distance between neighbouring depths that were delivered; 0 where fewer than three were.
  double step_m = 0;
  std::size_t pixels = 0;
};

struct MeasuredNoise {
  SensorModel model;
  std::vector<NoiseBin> bins;
  /// Largest relative deviation of a bin's sigma from the fitted one.
  double worst_fit = 0;
  /// Depth edges that the lateral noise was measured at; below kLeastEdges it was taken from the Kinect's figure.
  std::size_t edges = 0;
};

/// Collects depth images (metres, 0 where nothing was measured) of a camera and a scene at rest, and fits a model.
///
/// - Only pixels count that were measured in 80 % of the frames, lie three pixels away from a depth edge, and are seen
///   at less than 60 degrees.
/// - Variance over time, collected by Welford's method (1962), by geometric depth bins of 8 %. Where the sensor's steps
///   hide its noise, step^2 / 12 is the least.
/// - Polynomial in z: constant, linear or quadratic, as far as the range of depths carries it; least squares of the
///   relative deviations.
/// - Lateral sigma: a pixel at the distance d from a depth edge sees the other side with the probability Phi(-d/sigma),
///   so over the pixels beside an edge, d = 1/2, 3/2, ..., the shares of measurements from the other side sum up to
///   sigma / sqrt(2 pi).
/// - Rest is judged by von Neumann's ratio (1941): variance over half the mean squared step from frame to frame is 1
/// for
///   noise and greater for what moves or drifts.
class NoiseMeasurement {
 public:
  static constexpr int kLeastFrames = 20;
  static constexpr int kMostFrames = 100;
  static constexpr std::size_t kLeastEdges = 100;

  /// camera: pinhole intrinsics of the depth camera.
  explicit NoiseMeasurement(const Camera& camera) : camera_{camera} {}

  /// Refuses an image of another size than the camera's, and more than kMostFrames.
  [[nodiscard]] Status add(const DepthImage& measured);
  [[nodiscard]] int count() const { return static_cast<int>(frames_.size()); }
  /// Refuses fewer than kLeastFrames frames, a scene that moved, and one without enough surface.
  [[nodiscard]] Result<MeasuredNoise> fit() const;

 private:
  Camera camera_;
  std::vector<DepthImage> frames_;
};

/// The steps of the fit, one by one.
namespace noise {

/// One pixel over time.
struct PixelNoise {
  /// 0 where fewer than two frames measured it.
  float mean_m = 0;
  float variance_m2 = 0;
  /// Half the mean squared step from one measurement to the next.
  float step_variance_m2 = 0;
  float measured_share = 0;
};
[[nodiscard]] Image<PixelNoise> over_time(const std::vector<DepthImage>& frames);

/// Pixels of smooth surfaces that are not seen at a grazing angle.
[[nodiscard]] Image<std::uint8_t> smooth_surface(const Image<PixelNoise>& pixels, const Camera& camera);

[[nodiscard]] std::vector<NoiseBin> bins_of(const Image<PixelNoise>& pixels, const Image<std::uint8_t>& use,
                                            const std::vector<DepthImage>& frames);

/// Coefficients by depth; see NoiseMeasurement. There must be a bin.
[[nodiscard]] Eigen::Vector3d fit_polynomial(const std::vector<NoiseBin>& bins);

struct LateralNoise {
  double sigma_px = 0;
  std::size_t edges = 0;
};
[[nodiscard]] LateralNoise lateral_noise(const Image<PixelNoise>& pixels, const std::vector<DepthImage>& frames);

}  // namespace noise
}  // namespace meshloop
