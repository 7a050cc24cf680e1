#pragma once
// Things that hang together: disjoint sets, with path halving (Tarjan and van Leeuwen 1984).
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace meshloop {

/// At first each of the things stands for itself.
class Connected {
 public:
  explicit Connected(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }

  /// One more thing that stands for itself; its number.
  std::uint32_t add() {
    parent_.push_back(static_cast<std::uint32_t>(parent_.size()));
    return parent_.back();
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = first_of(a);
    b = first_of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  /// The first of all that hang together with it: the same for each of them.
  [[nodiscard]] std::uint32_t first_of(std::uint32_t thing) {
    while (parent_[thing] != thing) {
      parent_[thing] = parent_[parent_[thing]];
      thing = parent_[thing];
    }
    return thing;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace meshloop
