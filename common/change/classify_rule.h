#pragma once
// The rule that gives a pixel its label. C++ and GLSL ES compile this same text (both compare shaders include it), so
// it uses only what both languages share. Depths and thresholds are metres along the optical axis; 0 means none.
#ifdef __cplusplus
#include "common/change/label.h"
#define MESHLOOP_CONSTANT inline constexpr
#define MESHLOOP_RULE [[nodiscard]] constexpr
namespace meshloop::rule {
using uint = unsigned int;
#else
#define MESHLOOP_CONSTANT const
#define MESHLOOP_RULE
#endif

MESHLOOP_CONSTANT uint kUnmeasured = 0u;
MESHLOOP_CONSTANT uint kUnmodelled = 1u;
MESHLOOP_CONSTANT uint kCloser = 2u;
MESHLOOP_CONSTANT uint kFarther = 3u;
MESHLOOP_CONSTANT uint kAgrees = 4u;
MESHLOOP_CONSTANT uint kUndecided = 5u;

// A threshold this large says that nothing can be told at the pixel.
MESHLOOP_CONSTANT float kNoThreshold_m = 1e30f;

// False where the label is known without a look at the pixel's surroundings.
MESHLOOP_RULE bool needs_neighbourhood(float measured_m, float expected_m, float threshold_m) {
  if (!(measured_m > 0.0f)) return false;
  if (threshold_m >= kNoThreshold_m) return false;
  if (!(expected_m > 0.0f)) return true;
  float difference_m = measured_m - expected_m;
  return difference_m > threshold_m || difference_m < -threshold_m;
}

// nearest_m and farthest_m: the least and the greatest expected depth within the reach of the lateral uncertainty, the
// pixel itself and other surfaces than its own included (the threshold covers its own slope); both 0 where
// no surface is expected there. has_gap: some pixel in reach expects no surface.
MESHLOOP_RULE uint classify(float measured_m, float expected_m, float threshold_m, float nearest_m, float farthest_m,
                            bool has_gap) {
  if (!(measured_m > 0.0f)) return kUnmeasured;
  bool is_modelled = expected_m > 0.0f;
  if (threshold_m >= kNoThreshold_m) return is_modelled ? kUndecided : kUnmodelled;
  float difference_m = measured_m - expected_m;
  if (is_modelled && difference_m <= threshold_m && difference_m >= -threshold_m) return kAgrees;
  // A surface beside this pixel, or a mixture of two at a depth edge, may be what was measured.
  if (farthest_m > 0.0f && measured_m >= nearest_m - threshold_m && measured_m <= farthest_m + threshold_m) {
    return kUndecided;
  }
  if (!is_modelled) return kUnmodelled;
  if (difference_m < 0.0f) return kCloser;
  // Past the model's silhouette anything may lie behind.
  return has_gap ? kUndecided : kFarther;
}

#ifdef __cplusplus
static_assert(kUnmeasured == static_cast<uint>(Label::unmeasured) &&
              kUnmodelled == static_cast<uint>(Label::unmodelled));
static_assert(kCloser == static_cast<uint>(Label::closer) && kFarther == static_cast<uint>(Label::farther));
static_assert(kAgrees == static_cast<uint>(Label::agrees) && kUndecided == static_cast<uint>(Label::undecided));
}  // namespace meshloop::rule
#endif
#undef MESHLOOP_CONSTANT
#undef MESHLOOP_RULE
