#include "common/change/comparison.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/median.h"

namespace meshloop {

std::array<std::size_t, kLabels.size()> Comparison::counts() const {
  std::array<std::size_t, kLabels.size()> counts{};
  for (const auto label : labels.pixels()) ++counts[static_cast<std::size_t>(label)];
  return counts;
}

std::optional<double> Comparison::smallest_change_m() const {
  std::vector<float> thresholds;
  thresholds.reserve(threshold_m.size());
  for (std::size_t i = 0; i < threshold_m.size(); ++i) {
    // The difference is a number exactly where a pixel is measured and modelled.
    if (!std::isnan(difference_m.data()[i])) thresholds.push_back(threshold_m.data()[i]);
  }
  if (thresholds.empty()) return std::nullopt;
  const float middle = median(std::move(thresholds));
  if (!std::isfinite(middle)) return std::nullopt;
  return static_cast<double>(middle);
}

}  // namespace meshloop
