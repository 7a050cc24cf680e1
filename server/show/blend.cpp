#include "server/show/blend.h"

#include <algorithm>
#include <cmath>

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

double alpha_of(Label label, float difference_m, const OverlayOptions& options) {
  switch (info(label).opacity) {
    case Opacity::by_difference: {
      const double size = std::abs(static_cast<double>(difference_m));
      return std::isfinite(size) ? std::min(1.0, size / solid_difference_m(options)) : 1.0;
    }
    case Opacity::constant: {
      const double alpha = std::clamp(options.constant_alpha, 0.0, 1.0);
      return label == Label::unmeasured ? kUnmeasuredShare * alpha : alpha;
    }
    case Opacity::transparent:
      break;
  }
  return 0;
}

Rgb8 blend(Rgb8 below, Rgb8 color, double alpha) {
  const auto share = static_cast<int>(std::lround(alpha * 256));
  const auto mixed = [share](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>((a * (256 - share) + b * share + 128) >> 8);
  };
  return {mixed(below.r, color.r), mixed(below.g, color.g), mixed(below.b, color.b)};
}

}  // namespace meshloop::show
