#include "common/program/spread.h"

#include <algorithm>
#include <cstddef>

namespace meshloop {

std::optional<Spread> spread_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return Spread{at(0.5), at(0.95)};
}

}  // namespace meshloop
