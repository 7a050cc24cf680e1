#pragma once
#include <vector>

#include "server/show/overlay.h"

namespace meshloop {

/// A small colour picture of a region and its surroundings, the region outlined in the colour of its label.
struct RegionThumbnail {
  RegionId id = 0;
  /// At most kThumbnail_px wide and high.
  ColorImage picture;
};

inline constexpr int kThumbnail_px = 192;

/// Of those regions that the colour camera sees. Empty when the images do not have the rig's sizes.
[[nodiscard]] std::vector<RegionThumbnail> region_thumbnails(const Comparison& comparison, const DepthImage& measured,
                                                             const ColorImage& color, const Rig& rig,
                                                             const RegionMap& regions,
                                                             const std::vector<RegionId>& wanted, Palette palette);

}  // namespace meshloop
