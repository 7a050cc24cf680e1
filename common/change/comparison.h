#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/change/label.h"
#include "common/image/image.h"

namespace meshloop {

/// When a difference counts as a change.
struct Threshold {
  enum class Kind { fixed, k_sigma };
  Kind kind = Kind::k_sigma;
  /// Metres for Kind::fixed, multiples of sigma for Kind::k_sigma.
  double value = 3;
};

/// Measured against expected depth, for one frame, in the depth camera's pixels (without lens distortion).
struct Comparison {
  Image<Label> labels;
  /// Measured minus expected depth in metres; NaN where either is missing.
  Image<float> difference_m;
  /// Depth of the model along the optical axis; 0 where it has no surface.
  DepthImage expected;
  /// Position in Model::nodes of the surface that is seen, plus 1; 0 where there is none.
  Image<std::uint32_t> node_index;
  /// The smallest difference that counts as a change at this pixel, in metres; infinite where nothing can be told.
  Image<float> threshold_m;

  /// Pixels of each label, in the labels' order.
  [[nodiscard]] std::array<std::size_t, kLabels.size()> counts() const;

  /// The smallest change that can be told at this range, in metres: the median threshold over the pixels that are
  /// measured and modelled. Nothing when there is no such pixel, or nothing can be told at half of them.
  [[nodiscard]] std::optional<double> smallest_change_m() const;
};

}  // namespace meshloop
