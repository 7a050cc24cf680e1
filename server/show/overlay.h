#pragma once
// Pictures of a comparison: over the depth image, and over the colour image turned to grey; with legend and colour bar.
#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/rig.h"
#include "common/image/image.h"

namespace meshloop {

enum class Palette { paper, color_blind_safe };

struct OverlayOptions {
  Palette palette = Palette::paper;
  /// alpha = |difference| * opacity, clamped to 1. Per metre.
  double opacity_per_m = 25;
  /// Alpha of labels that have no difference.
  double constant_alpha = 0.45;
  /// Legend and colour bar below the picture.
  bool legend = true;
  /// A line of text above the legend, for example "frame 12, 3 sigma".
  std::string title;
};

/// Over the measured depth, drawn as grey.
[[nodiscard]] ColorImage overlay_on_depth(const Comparison& comparison, const DepthImage& measured,
                                          const OverlayOptions& options);

/// Over the colour image in grey: each depth pixel is carried into the colour camera (common/geometry/README.md, "From
/// a depth pixel") as a small surface, visibility resolved by depth. Confirmed regions are framed and numbered when
/// `regions` is not null.
[[nodiscard]] ColorImage overlay_on_color(const Comparison& comparison, const DepthImage& measured,
                                          const ColorImage& color, const Rig& rig, const RegionMap* regions,
                                          const OverlayOptions& options);

}  // namespace meshloop
