#pragma once
#include "common/image/image.h"

namespace meshloop {

struct LocalContrastOptions {
  /// Side of the neighbourhood whose mean and spread are taken out.
  int window_px = 31;
  /// Grey levels of spread below which a neighbourhood counts as flat, so that its noise is not blown up.
  double floor = 6;
};

/// The image without its local brightness and contrast, lightly smoothed: (grey - mean) / (spread + floor), with 128 in
/// the middle. Two pictures of one surface under different light, exposure or gamma then look alike. Where mask (when
/// not empty) is 0 the result is 128, and these pixels count in no neighbourhood.
[[nodiscard]] GreyImage local_contrast(const GreyImage& grey, const GreyImage& mask,
                                       const LocalContrastOptions& options);

}  // namespace meshloop
