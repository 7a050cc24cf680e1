#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "common/change/label.h"
#include "server/show/overlay.h"

namespace meshloop::show {

[[nodiscard]] Rgb8 color_of(Label label, Palette palette);

/// The difference from which on a colour is solid, in metres; finite and positive whatever the opacity is.
[[nodiscard]] double solid_difference_m(const OverlayOptions& options);

/// Where the colour bar ends, in metres: at solid_difference_m, or farther for the smallest change's sake.
[[nodiscard]] double bar_end_m(const OverlayOptions& options);

/// Covers pixels with the colours of their labels. alpha = |difference| * opacity, clamped to 1, or constant (label.h
/// says which); missing measurements get half the constant: they are often large, and are no change.
class Paint {
 public:
  explicit Paint(const OverlayOptions& options);

  /// 0 to 1. An unknown difference counts as a large one.
  [[nodiscard]] float alpha_of(Label label, float difference_m) const {
    const Law& law = laws_[static_cast<std::size_t>(label)];
    const float alpha = law.constant + law.per_m * std::abs(difference_m);
    return law.per_m == 0 ? law.constant : alpha < 1 ? alpha : 1;
  }

  /// (1 - alpha) * below + alpha * colour, to 1/256.
  [[nodiscard]] Rgb8 cover(Rgb8 below, Label label, float difference_m) const {
    const float alpha = alpha_of(label, difference_m);
    if (alpha == 0) return below;
    const Rgb8 color = laws_[static_cast<std::size_t>(label)].color;
    const int share = static_cast<int>(alpha * 256 + 0.5f);
    const auto mixed = [share](std::uint8_t a, std::uint8_t b) {
      return static_cast<std::uint8_t>((a * (256 - share) + b * share + 128) >> 8);
    };
    return {mixed(below.r, color.r), mixed(below.g, color.g), mixed(below.b, color.b)};
  }

 private:
  struct Law {
    Rgb8 color;
    float constant = 0;
    float per_m = 0;
  };
  std::array<Law, kLabels.size()> laws_;
};

}  // namespace meshloop::show
