#pragma once
// What both versions of the comparison check and hold to be true of their input.
#include "server/compare/comparator.h"

namespace meshloop {

/// Rounding of the model's vertices to the scene's finest lattice (common/mesh/lattice.h), at most this far along an
/// axis. A snapshot's patch may lie on a coarser one; its measured noise is larger than that, and is not in here either
/// (CompareInput::model_sigma_m is).
inline constexpr double kLatticeSigma_m = 0.00012;
/// A pixel measures over its whole area, as wide as one pixel: the least lateral sigma of any sensor.
inline constexpr double kFootprintSigma_px = 0.288675;  // 1 / sqrt(12)
/// Nothing can be told where the threshold is larger (Threshold::Kind::k_sigma only).
inline constexpr double kLargestThreshold_m = 0.25;
/// Nor where the surface is seen at a steeper angle from its normal.
inline constexpr double kSteepestSeen_deg = 88;
/// Farther than this to each side no surface is looked for that could explain a measurement.
inline constexpr int kLargestReach_px = 4;

/// One sentence for what cannot be compared: no model or image, sizes that differ, a pose that is lost or not rigid, a
/// covariance or a threshold that is not a number.
[[nodiscard]] Status validate(const CompareInput& input);

/// Measured depth without what is not a depth (negative, infinite, not a number).
[[nodiscard]] inline float usable_depth(float z_m) {
  return z_m > 0 && z_m < 1e6F ? z_m : 0.0F;
}

}  // namespace meshloop
