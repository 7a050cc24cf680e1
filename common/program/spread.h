#pragma once
#include <optional>
#include <vector>

namespace meshloop {

struct Spread {
  double median = 0;
  double p95 = 0;
};

/// Nothing without values.
[[nodiscard]] std::optional<Spread> spread_of(std::vector<double> values);

}  // namespace meshloop
