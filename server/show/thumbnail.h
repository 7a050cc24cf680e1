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

/// Of those regions that the colour camera sees. `source`: ColorOverlay::source_of. Empty when images that belong
/// together do not have one size.
[[nodiscard]] std::vector<RegionThumbnail> region_thumbnails(const Image<std::uint32_t>& source,
                                                             const Comparison& comparison, const ColorImage& color,
                                                             const RegionMap& regions,
                                                             const std::vector<RegionId>& wanted, Palette palette);

}  // namespace meshloop
