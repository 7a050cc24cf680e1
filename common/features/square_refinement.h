#pragma once
// Corners of a dark square on a bright ground to a few hundredths of a pixel: lines are fitted to its four sides and
// intersected. Used inside this room.
#include <Eigen/Core>
#include <array>

#include "common/image/image.h"

namespace meshloop {

/// `pixels`: the corners to about a pixel, clockwise as seen in the image. `cells`: how many cells the square has along
/// a side; the outermost must be dark. False, with the corners untouched, where the sides are not clear enough.
[[nodiscard]] bool refine_square(const GreyImage& image, int cells, std::array<Eigen::Vector2d, 4>& pixels);

}  // namespace meshloop
