#pragma once
#include <array>

#include "server/show/overlay.h"

namespace meshloop::show {

/// Title, swatches with the names and meanings of the labels that are shown, and a bar with the law of opacity in
/// millimetres or metres; `width` pixels wide, as high as needed. width is at least 300.
[[nodiscard]] ColorImage draw_legend(int width, const std::array<bool, kLabels.size()>& shown,
                                     const OverlayOptions& options);

}  // namespace meshloop::show
