#pragma once
#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

namespace meshloop {

/// Of an even number of values the larger one of the two in the middle. There must be some.
template <class T>
[[nodiscard]] T median(std::vector<T> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace meshloop
