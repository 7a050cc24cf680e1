#include "common/change/comparison.h"

namespace meshloop {

std::array<std::size_t, kLabels.size()> Comparison::counts() const {
  std::array<std::size_t, kLabels.size()> counts{};
  for (const auto label : labels.pixels()) ++counts[static_cast<std::size_t>(label)];
  return counts;
}

}  // namespace meshloop
