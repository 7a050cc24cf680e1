#pragma once
#include <cstdint>

#include "common/geometry/rig.h"
#include "common/image/image.h"
#include "common/simulation/scene.h"

namespace meshloop::simulation {

/// Exact images, by ray casting through pixel centres. Lens distortion is left out. The same scene and pose give the
/// same bits on any number of threads; `threads` 0 takes one for each processor. T_camera_world must be rigid.
struct ExactDepth {
  /// Metres along the optical axis; 0 where no solid is.
  DepthImage depth;
  /// Index of the solid seen, plus 1.
  Image<std::uint16_t> solid;
  /// Cosine between ray and surface normal.
  Image<float> cos_theta;
};
[[nodiscard]] ExactDepth cast_depth(const Scene& scene, const Camera& camera, const Pose& T_camera_world,
                                    bool modelled_only, int threads = 0);
/// Colour with one fixed lamp that throws shadows. Anti-aliased by supersampling x supersampling rays where a pixel
/// differs from its neighbours in surface, shadow or, visibly, in colour; one ray elsewhere, also inside the
/// background.
[[nodiscard]] ColorImage cast_color(const Scene& scene, const Camera& camera, const Pose& T_camera_world,
                                    int supersampling, int threads = 0);

struct NoiseOptions {
  /// 1 is the sensor's own noise, 0 none at all: exact depth in the sensor's range, no quantisation, nothing missing
  /// (then depth is rounded only by the recording's 16 bits). Lengths of the sensor model are multiplied by it.
  double strength = 1;
  /// Seed of this frame.
  std::uint64_t seed = 0;
};
/// What the depth sensor would deliver: axial and lateral noise and quantisation of the sensor model, range 0.4 to 4.5
/// m, nothing measured beyond 80 degrees and, for the Kinect's models, in the shadow of the projector (7.5 cm to the
/// side) and at a share of the pixels along silhouettes. The standard deviation of what is delivered, quantisation
/// included, is the sensor model's. Pixels are independent; the same seed gives the same image.
[[nodiscard]] DepthImage measure(const ExactDepth& exact, const Camera& camera, const SensorModel& sensor,
                                 const NoiseOptions& options);
/// Gaussian noise of `sigma` grey levels times strength.
void add_color_noise(ColorImage& image, double sigma, std::uint64_t seed);

}  // namespace meshloop::simulation
