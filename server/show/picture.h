#pragma once
// What is drawn around and on a finished overlay: frames of regions, legend, colour bar.
#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "server/show/overlay.h"

namespace meshloop::show {

/// Narrower pictures are enlarged so that the legend stays readable.
inline constexpr int kNarrowest = 640;

/// The picture, enlarged by a whole number when it is narrower than kNarrowest and gets a legend; with its marks; and,
/// below it, the legend for the labels for which shown[label] is true.
[[nodiscard]] ColorImage finish(const ColorImage& picture, const std::vector<OverlayFrame>& marks,
                                const std::array<bool, kLabels.size()>& shown, const OverlayOptions& options);

}  // namespace meshloop::show
