#include "server/adjust/places.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace meshloop::adjust {

std::vector<std::uint32_t> places_of(const std::vector<Eigen::Vector3f>& positions) {
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    return std::array<float, 3>{positions[i].x(), positions[i].y(), positions[i].z()};
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<std::uint32_t> welded(positions.size());
  std::uint32_t first = 0;
  for (const auto i : order) {
    if (key(first) != key(i) || i == order.front()) first = i;
    welded[i] = first;
  }
  return welded;
}

}  // namespace meshloop::adjust
