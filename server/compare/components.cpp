#include "server/compare/components.h"

#include <algorithm>
#include <utility>

namespace meshloop {
namespace {

// Pixels that follow each other at this distance, in rows or columns, are connected: 1 touches, 2 leaves a gap of one.
constexpr int kReach = 2;

// Sets that grow together (Tarjan 1975); a set is named by its smallest member.
class DisjointSets {
 public:
  std::uint32_t add() {
    parents_.push_back(static_cast<std::uint32_t>(parents_.size()));
    return parents_.back();
  }
  std::uint32_t find(std::uint32_t member) {
    while (parents_[member] != member) {
      parents_[member] = parents_[parents_[member]];
      member = parents_[member];
    }
    return member;
  }
  std::uint32_t join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (b < a) std::swap(a, b);
    parents_[b] = a;
    return a;
  }
  [[nodiscard]] std::size_t size() const { return parents_.size(); }

 private:
  std::vector<std::uint32_t> parents_;
};

std::vector<std::size_t> changed_pixels(const Image<Label>& labels) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (is_change(labels.data()[i])) pixels.push_back(i);
  }
  return pixels;
}

// The set of pixel (u, v), joined with those of its kind in the part of its surroundings that has been visited.
std::uint32_t set_of(const Image<Label>& labels, const Image<std::uint32_t>& sets, int u, int v, DisjointSets& joined) {
  const ChangeKind kind = kind_of(labels(u, v));
  std::uint32_t set = 0;
  for (int y = std::max(v - kReach, 0); y <= v; ++y) {
    const int last = y < v ? std::min(u + kReach, labels.width() - 1) : u - 1;
    for (int x = std::max(u - kReach, 0); x <= last; ++x) {
      const std::uint32_t other = sets(x, y);
      if (other == 0 || other == set || kind_of(labels(x, y)) != kind) continue;
      set = set == 0 ? other : joined.join(set, other);
    }
  }
  return set == 0 ? joined.add() : set;
}

}  // namespace

Components connect_changes(const Image<Label>& labels) {
  Components result{Image<std::uint32_t>(labels.width(), labels.height()), 0, changed_pixels(labels)};
  DisjointSets joined;
  joined.add();  // 0 is no set
  const auto width = static_cast<std::size_t>(labels.width());
  for (const std::size_t pixel : result.pixels) {
    const auto u = static_cast<int>(pixel % width);
    const auto v = static_cast<int>(pixel / width);
    result.numbers.data()[pixel] = set_of(labels, result.numbers, u, v, joined);
  }
  std::vector<std::uint32_t> number_of(joined.size(), 0);
  for (std::uint32_t set = 1; set < number_of.size(); ++set) {
    if (joined.find(set) == set) number_of[set] = ++result.count;
  }
  for (const std::size_t pixel : result.pixels) {
    auto& number = result.numbers.data()[pixel];
    number = number_of[joined.find(number)];
  }
  return result;
}

}  // namespace meshloop
