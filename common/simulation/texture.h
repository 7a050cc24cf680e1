#pragma once
// Procedural textures. Costly ones are painted into bitmaps once, when the texture is made.
#include <cstdint>

#include "common/simulation/scene.h"

namespace meshloop::simulation {

/// A picture with a scale; outside it the pattern repeats.
class Bitmap {
 public:
  Bitmap(double width_m, double height_m, double pixel_m);

  [[nodiscard]] Image<Rgb8>& pixels() { return pixels_; }
  [[nodiscard]] double pixel_m() const { return pixel_m_; }
  /// Interpolated colour; x to the right, y downwards, metres from the upper left corner.
  [[nodiscard]] Rgb8 at(double x_m, double y_m) const;

 private:
  Image<Rgb8> pixels_;
  double pixel_m_;
};

[[nodiscard]] Rgb8 scaled(Rgb8 color, double factor);
[[nodiscard]] Rgb8 blended(Rgb8 a, Rgb8 b, double share_of_b);
/// Smooth noise in [-1, 1] with features of size 1 (Perlin's value noise on the integer lattice).
[[nodiscard]] double smooth_noise(double x, double y, std::uint64_t seed);

/// One colour that varies by two percent and darkens towards the edges of a box of this size.
[[nodiscard]] Texture plain(Rgb8 color, const Eigen::Vector3d& size, std::uint64_t seed);
/// Wood with its grain along the x axis (on faces across x: along y).
[[nodiscard]] Texture wood(Rgb8 light, Rgb8 dark, std::uint64_t seed);
/// Printed wrapping paper on a box of this size: letters, blocks, discs and stripes of about 1 cm in strong contrast,
/// nothing repeated, and a ribbon.
[[nodiscard]] Texture wrapping_paper(const Eigen::Vector3d& size, std::uint64_t seed);

}  // namespace meshloop::simulation
