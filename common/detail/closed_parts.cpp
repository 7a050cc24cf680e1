#include "common/detail/closed_parts.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace meshloop {
namespace {

/// Numbers the sets of vertices that hang together, from zero.
class Connected {
 public:
  explicit Connected(std::size_t vertices) : parent_(vertices) { std::iota(parent_.begin(), parent_.end(), 0U); }

  void join(std::uint32_t a, std::uint32_t b) {
    a = first_of(a);
    b = first_of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  /// By vertex; how many there are.
  std::pair<std::vector<std::uint32_t>, std::uint32_t> number() {
    std::vector<std::uint32_t> numbers(parent_.size());
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < numbers.size(); ++v) {
      const std::uint32_t first = first_of(v);
      numbers[v] = first == v ? count++ : numbers[first];
    }
    return {std::move(numbers), count};
  }

 private:
  std::uint32_t first_of(std::uint32_t vertex) {
    while (parent_[vertex] != vertex) {
      parent_[vertex] = parent_[parent_[vertex]];
      vertex = parent_[vertex];
    }
    return vertex;
  }

  std::vector<std::uint32_t> parent_;
};

/// Numbers of edges that look random, so that a sum of them is zero only where each edge meets its opposite (but for
/// one case in 2^64). The mixing is that of SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t number_of_edge(std::uint32_t from, std::uint32_t to) {
  const auto [low, high] = std::minmax(from, to);
  std::uint64_t z = ((std::uint64_t{high} << 32) | low) + 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  z ^= z >> 31;
  return from < to ? z : 0 - z;
}

struct Part {
  std::uint64_t unmatched_edges = 0;
  /// Six times the volume.
  double volume = 0;
  /// One of its vertices, from which the volume is measured, so that a part far from the origin loses no digits.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::AlignedBox3f bounds;

  void add(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
    if (bounds.isEmpty()) origin = a.cast<double>();
    const auto seen = [&](const Eigen::Vector3f& p) -> Eigen::Vector3d { return p.cast<double>() - origin; };
    volume += seen(a).dot(seen(b).cross(seen(c)));
    bounds.extend(a).extend(b).extend(c);
  }
  [[nodiscard]] bool is_closed() const { return unmatched_edges == 0 && volume > 0; }
};

}  // namespace

ClosedParts closed_parts_of(const std::vector<Eigen::Vector3f>& positions, std::span<const Triangle> triangles) {
  Connected connected{positions.size()};
  for (const auto& [a, b, c] : triangles) {
    connected.join(a, b);
    connected.join(b, c);
  }
  const auto [part_of_vertex, count] = connected.number();
  std::vector<Part> parts(count);
  for (const auto& [a, b, c] : triangles) {
    Part& part = parts[part_of_vertex[a]];
    part.unmatched_edges += number_of_edge(a, b) + number_of_edge(b, c) + number_of_edge(c, a);
    part.add(positions[a], positions[b], positions[c]);
  }
  ClosedParts result;
  std::vector<std::int32_t> number(count, ClosedParts::kNone);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!parts[i].is_closed()) continue;
    number[i] = static_cast<std::int32_t>(result.bounds.size());
    result.bounds.push_back(parts[i].bounds);
  }
  for (const auto part : part_of_vertex) result.of_vertex.push_back(number[part]);
  return result;
}

}  // namespace meshloop
