#pragma once
// From pixels to the straight lines that bound them.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/image/image.h"

namespace meshloop::adjust {

/// A closed line in pixels, without its first point again at the end.
using Loop = std::vector<Eigen::Vector2d>;

/// More than the half pixel by which a border's steps lie off a straight line.
inline constexpr double kStraightSteps_px = 1;

/// The lines around the pixels that are not 0, in the image's pixels (pixel (0, 0) reaches from -0.5 to 0.5): outer
/// lines one way round, holes the other. Pixels that touch at a corner only are apart. Lines and holes around less than
/// `smallest_px` pixels are left out. Straight borders become straight lines, through the middle of their steps;
/// steps up to `straight_px` from a line are on it.
[[nodiscard]] std::vector<Loop> outline_of(const Image<std::uint8_t>& mask, double smallest_px,
                                           double straight_px = kStraightSteps_px);

}  // namespace meshloop::adjust
