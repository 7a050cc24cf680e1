#include "server/show/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "server/show/blend.h"
#include "server/show/carry.h"
#include "server/show/picture.h"

namespace meshloop {
namespace {

using Shown = std::array<bool, kLabels.size()>;

template <class A, class B>
bool same_size(const Image<A>& a, const Image<B>& b) {
  return a.width() == b.width() && a.height() == b.height() && !a.empty();
}

bool complete(const Comparison& c, const DepthImage& measured) {
  return same_size(c.labels, measured) && same_size(c.difference_m, measured) && same_size(c.expected, measured);
}

/// Depths of the 2nd and 98th percentile, so that a few wrong measurements do not take the contrast.
struct Range {
  float near_m = 0;
  float far_m = 1;
};

Range robust_range(const DepthImage& measured) {
  constexpr float kBin_m = 0.002f;
  constexpr std::size_t kBins = 8192;
  std::vector<std::size_t> histogram(kBins, 0);
  std::size_t all = 0;
  for (const float z : measured.pixels()) {
    if (!(z > 0)) continue;
    ++histogram[std::min(static_cast<std::size_t>(std::min(z / kBin_m, 1e6f)), kBins - 1)];
    ++all;
  }
  const auto percentile = [&](double share) {
    const auto wanted = static_cast<std::size_t>(share * static_cast<double>(all));
    std::size_t below = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      below += histogram[i];
      if (below > wanted) return kBin_m * (static_cast<float>(i) + 0.5f);
    }
    return kBin_m * static_cast<float>(kBins);
  };
  return {percentile(0.02), percentile(0.98)};
}

// Near is bright; not so bright or dark that colours over it could not be told.
ColorImage depth_as_grey(const DepthImage& measured) {
  constexpr float kBright = 225;
  constexpr float kDark = 50;
  constexpr Rgb8 kNothing{70, 70, 70};
  const Range range = robust_range(measured);
  const float scale = (kBright - kDark) / std::max(range.far_m - range.near_m, 1e-3f);
  ColorImage grey{measured.width(), measured.height()};
  std::transform(measured.pixels().begin(), measured.pixels().end(), grey.pixels().begin(), [&](float z) {
    if (!(z > 0)) return kNothing;
    const auto value = static_cast<std::uint8_t>(std::clamp(kBright - (z - range.near_m) * scale, kDark, kBright));
    return Rgb8{value, value, value};
  });
  return grey;
}

// `region_at(x, y)` is the region that a pixel of the picture shows, or 0.
template <class RegionAt>
std::vector<OverlayFrame> marks_of(const RegionMap& regions, const std::map<RegionId, std::string>& texts, int width,
                                   int height, RegionAt region_at) {
  std::unordered_map<RegionId, Eigen::AlignedBox2i> boxes;
  RegionId last = 0;
  Eigen::AlignedBox2i* box = nullptr;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const RegionId id = region_at(x, y);
      if (id == 0) continue;
      if (id != last) box = &boxes[last = id];
      box->extend(Eigen::Vector2i{x, y});
    }
  }
  std::vector<OverlayFrame> marks;
  for (const auto& region : regions.regions) {
    const auto seen = boxes.find(region.id);
    if (!region.confirmed || seen == boxes.end()) continue;
    const auto text = texts.find(region.id);
    marks.push_back({seen->second, text != texts.end()
                                       ? text->second
                                       : fmt::format("region {}: {:.0f} cm2", region.id, region.area_m2 * 1e4)});
  }
  return marks;
}

}  // namespace

ColorImage overlay_on_depth(const Comparison& comparison, const DepthImage& measured, const RegionMap* regions,
                            const OverlayOptions& options) {
  if (!complete(comparison, measured)) return {};
  ColorImage picture = depth_as_grey(measured);
  const show::Paint paint{options};
  Shown shown{};
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const Label label = comparison.labels.data()[i];
    shown[static_cast<std::size_t>(label)] = true;
    picture.data()[i] = paint.cover(picture.data()[i], label, comparison.difference_m.data()[i]);
  }
  std::vector<OverlayFrame> marks;
  if (regions != nullptr && same_size(regions->ids, measured)) {
    marks = marks_of(*regions, options.region_texts, measured.width(), measured.height(),
                     [&](int x, int y) { return regions->ids(x, y); });
  }
  return show::finish(picture, marks, shown, options);
}

ColorOverlay::ColorOverlay(std::unique_ptr<show::Carrier> carrier) : carrier_{std::move(carrier)} {}
ColorOverlay::~ColorOverlay() = default;
ColorOverlay::ColorOverlay(ColorOverlay&& other) noexcept = default;
ColorOverlay& ColorOverlay::operator=(ColorOverlay&& other) noexcept = default;

Result<ColorOverlay> ColorOverlay::create(GpuContext& context) {
  auto carrier = show::Carrier::create(context);
  if (!carrier) return fail(carrier.error());
  return ColorOverlay{std::move(*carrier)};
}

Result<Image<std::uint32_t>> ColorOverlay::source_of(const Comparison& comparison, const DepthImage& measured,
                                                     const Rig& rig) {
  const bool fits = measured.width() == rig.depth.width && measured.height() == rig.depth.height;
  if (!fits || !complete(comparison, measured)) {
    return fail(fmt::format("a view over colour needs depth images of the rig's size, {} x {}", rig.depth.width,
                            rig.depth.height));
  }
  return carrier_->carry(comparison, measured, rig);
}

Result<ColorImage> ColorOverlay::draw(const Comparison& comparison, const DepthImage& measured, const ColorImage& color,
                                      const Rig& rig, const RegionMap* regions, const OverlayOptions& options) {
  if (color.width() != rig.color.width || color.height() != rig.color.height || color.empty()) {
    return fail(fmt::format("a view over colour needs an image of the rig's size, {} x {}, not {} x {}",
                            rig.color.width, rig.color.height, color.width(), color.height()));
  }
  const auto source = source_of(comparison, measured, rig);
  if (!source) return fail(source.error());
  ColorImage picture = to_color(to_grey(color));
  const show::Paint paint{options};
  Shown shown{};
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const std::uint32_t from = source->data()[i];
    if (from == 0) continue;
    const Label label = comparison.labels.data()[from - 1];
    shown[static_cast<std::size_t>(label)] = true;
    picture.data()[i] = paint.cover(picture.data()[i], label, comparison.difference_m.data()[from - 1]);
  }
  std::vector<OverlayFrame> marks;
  if (regions != nullptr && same_size(regions->ids, measured)) {
    marks = marks_of(*regions, options.region_texts, color.width(), color.height(), [&](int x, int y) -> RegionId {
      const std::uint32_t from = (*source)(x, y);
      return from == 0 ? 0 : regions->ids.data()[from - 1];
    });
  }
  const Eigen::AlignedBox2i inside{Eigen::Vector2i{0, 0}, Eigen::Vector2i{color.width() - 1, color.height() - 1}};
  for (const auto& frame : options.frames) {
    const auto box = frame.box.intersection(inside);
    if (!box.isEmpty()) marks.push_back({box, frame.text});
  }
  return show::finish(picture, marks, shown, options);
}

}  // namespace meshloop
