#include "server/show/blend.h"

#include <algorithm>

namespace meshloop::show {
namespace {

constexpr double kUnmeasuredShare = 0.5;

}  // namespace

Rgb8 color_of(Label label, Palette palette) {
  return palette == Palette::paper ? info(label).paper_color : info(label).safe_color;
}

double solid_difference_m(const OverlayOptions& options) {
  constexpr double kSmallest_per_m = 1e-3;
  constexpr double kLargest_per_m = 1e6;
  const double opacity = std::isfinite(options.opacity_per_m) ? options.opacity_per_m : kSmallest_per_m;
  return 1 / std::clamp(opacity, kSmallest_per_m, kLargest_per_m);
}

double bar_end_m(const OverlayOptions& options) {
  constexpr double kLargest_m = 1000;
  const double solid = solid_difference_m(options);
  const double wanted = 2 * options.smallest_change_m;
  if (!(wanted > solid) || wanted > kLargest_m) return solid;
  // The next of 1, 2, 5, 10, ...
  const double decade = std::pow(10, std::floor(std::log10(wanted)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (wanted <= step * decade * (1 + 1e-9)) return step * decade;
  }
  return 10 * decade;
}

Paint::Paint(const OverlayOptions& options) {
  const double given = std::isfinite(options.constant_alpha) ? options.constant_alpha : 0.0;
  const double constant = std::clamp(given, 0.0, 1.0);
  for (const auto& label : kLabels) {
    Law& law = laws_[static_cast<std::size_t>(label.label)];
    law.color = color_of(label.label, options.palette);
    if (label.opacity == Opacity::by_difference) law.per_m = static_cast<float>(1 / solid_difference_m(options));
    if (label.opacity != Opacity::constant) continue;
    law.constant = static_cast<float>(label.label == Label::unmeasured ? kUnmeasuredShare * constant : constant);
  }
}

}  // namespace meshloop::show
