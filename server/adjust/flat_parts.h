#pragma once
// The flat parts of a depth grid.
#include <cstdint>
#include <vector>

#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {

/// A plane as the camera sees it: one divided by the depth is linear in the picture. In the window's pixels: at column
/// x and row y of the window the depth is 1 / at(x, y).
struct PicturePlane {
  double per_column = 0;
  double per_row = 0;
  double at_corner = 0;
  [[nodiscard]] double at(double x, double y) const { return per_column * x + per_row * y + at_corner; }
  /// Metres; 0 where the plane is farther away than a kilometre, or behind the camera.
  [[nodiscard]] float depth(double x, double y) const {
    const double inverse_z = at(x, y);
    return inverse_z > 1e-3 ? static_cast<float>(1 / inverse_z) : 0;
  }
};

struct FlatParts {
  std::vector<PicturePlane> planes;
  /// For each pixel of the window the position of its plane, plus 1; 0 where it is on none.
  std::vector<std::uint16_t> plane_of_pixel;
};

/// Planes grown over blocks of 8x8 pixels: a block is on a plane when the mean of its measurements is within half a
/// sigma of it and their spread is the sensor's. Then pixel by pixel up to the lines in which the planes meet. What has
/// less than 4 blocks is not flat but small. Only members are on planes.
[[nodiscard]] FlatParts find_flat_parts(const DepthGrid& grid);

/// Pixels without a measurement that lie among those of one plane (seven of the eight around them) become gaps on it.
/// Notches in an outline stay what they are.
void fill_gaps(DepthGrid& grid, FlatParts& parts, const DepthImage& measured);

/// Puts the depth of every pixel on a plane onto it.
void snap_to_planes(DepthGrid& grid, const FlatParts& parts);

}  // namespace meshloop::adjust
