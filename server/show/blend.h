#pragma once
#include <array>
#include <cstdint>

#include "common/change/label.h"
#include "server/show/overlay.h"

namespace meshloop::show {

[[nodiscard]] Rgb8 color_of(Label label, Palette palette);

/// How strongly a label's colour covers the picture, 0 to 1: |difference| * opacity, clamped, or constant (see
/// label.h). Missing measurements get half the constant: they are often large, and are no change.
[[nodiscard]] double alpha_of(Label label, float difference_m, const OverlayOptions& options);

/// (1 - alpha) * below + alpha * color, rounded.
[[nodiscard]] Rgb8 blend(Rgb8 below, Rgb8 color, double alpha);

/// The difference from which on a colour is solid, in metres; finite and positive whatever the opacity is.
[[nodiscard]] double solid_difference_m(const OverlayOptions& options);

}  // namespace meshloop::show
