#pragma once
#include <cstdint>

#include "common/change/comparison.h"
#include "common/geometry/rig.h"
#include "common/image/image.h"

namespace meshloop::show {

/// For each pixel of the colour image: position in the depth image of what it sees, plus 1; 0 where that is unknown.
///
/// Each measured pixel is drawn as a small square facing the camera, as large as the pixel is on its surface, the
/// nearest one wins. Where no measurement lands, unmeasured pixels are drawn at the model's depth, so that a missing
/// measurement shows on the surface that was expected.
[[nodiscard]] Image<std::uint32_t> carry_to_color(const Comparison& comparison, const DepthImage& measured,
                                                  const Rig& rig);

}  // namespace meshloop::show
