#pragma once
#include <string>

#include "common/image/image.h"
#include "device/draw/ar_renderer.h"

namespace meshloop {

/// "revision 4 | tracking | 28 frames/s"
[[nodiscard]] std::string hud_text(const HudState& state);

/// Writes the text small into the lower left corner, on a darkened strip so that it can be read on any picture. A
/// picture too small for it stays as it is.
void draw_hud(ColorImage& picture, const HudState& state);

}  // namespace meshloop
