#pragma once
// Pictures of a comparison: over the depth image, and over the colour image turned to grey; with legend and colour bar.
#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/rig.h"
#include "common/gpu/context.h"
#include "common/image/image.h"

namespace meshloop {

enum class Palette { paper, color_blind_safe };

/// A frame with a line of text, in the pixels of the picture before it is enlarged.
struct OverlayFrame {
  Eigen::AlignedBox2i box;
  std::string text;
};

struct OverlayOptions {
  Palette palette = Palette::paper;
  /// alpha = |difference| * opacity, clamped to 1. Per metre.
  double opacity_per_m = 25;
  /// Alpha of labels that have no difference.
  double constant_alpha = 0.45;
  /// The smallest change that can be told, in metres (0: unknown). The bar reaches twice as far at least, so that it
  /// has differences that the picture can show.
  double smallest_change_m = 0;
  /// Legend and colour bar below the picture.
  bool legend = true;
  /// A line of text above the legend, for example "frame 12, 3 sigma".
  std::string title;
  /// What stands at a region's frame in place of "region 3: 214 cm2".
  std::map<RegionId, std::string> region_texts;
  /// Frames beside those of regions; of a view over colour in the colour image's pixels, and what lies outside is not
  /// drawn.
  std::vector<OverlayFrame> frames;
};

/// Over the measured depth, drawn as grey. Confirmed regions are framed and numbered when `regions` is not null. Images
/// of different sizes give an empty picture.
[[nodiscard]] ColorImage overlay_on_depth(const Comparison& comparison, const DepthImage& measured,
                                          const RegionMap* regions, const OverlayOptions& options);

namespace show {
class Carrier;
}

/// Over the colour image in grey: each depth pixel is carried into the colour camera (common/geometry/README.md, "From
/// a depth pixel") as a small surface, visibility resolved by depth on the GPU. One thread, that of the context.
class ColorOverlay {
 public:
  [[nodiscard]] static Result<ColorOverlay> create(GpuContext& context);
  ~ColorOverlay();
  ColorOverlay(ColorOverlay&& other) noexcept;
  ColorOverlay& operator=(ColorOverlay&& other) noexcept;

  /// Confirmed regions are framed and numbered when `regions` is not null. Refuses images that have not the rig's
  /// sizes, and what the graphics driver has no room for.
  [[nodiscard]] Result<ColorImage> draw(const Comparison& comparison, const DepthImage& measured,
                                        const ColorImage& color, const Rig& rig, const RegionMap* regions,
                                        const OverlayOptions& options);

  /// For each pixel of the colour image the position of the depth pixel that is seen there, plus 1; 0 for none. Refuses
  /// as `draw` does.
  [[nodiscard]] Result<Image<std::uint32_t>> source_of(const Comparison& comparison, const DepthImage& measured,
                                                       const Rig& rig);

 private:
  explicit ColorOverlay(std::unique_ptr<show::Carrier> carrier);
  std::unique_ptr<show::Carrier> carrier_;
};

}  // namespace meshloop
