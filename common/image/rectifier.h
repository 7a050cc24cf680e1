#pragma once
#include <vector>

#include "common/geometry/camera.h"
#include "common/image/image.h"

namespace meshloop {

/// Takes the lens distortion out of images, for the pinhole camera with the same intrinsics. The map is computed once.
/// Colour is interpolated; depth takes the nearest measurement, since a mean of two depths lies on neither surface.
class Rectifier {
 public:
  explicit Rectifier(const Camera& camera);

  /// Images must have the camera's size. Pixels from outside, or from beyond Camera::lens_limit(), become black, or 0.
  [[nodiscard]] ColorImage rectify(const ColorImage& image) const;
  [[nodiscard]] DepthImage rectify(const DepthImage& image) const;

 private:
  Camera camera_;
  bool identity_;
  /// For each pixel of the result, where it lies in the source.
  std::vector<Eigen::Vector2f> source_;
};

}  // namespace meshloop
