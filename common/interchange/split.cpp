#include "common/interchange/split.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <span>

#include "common/base/connected.h"

namespace meshloop {
namespace {

using TriangleIds = std::span<std::uint32_t>;

Eigen::Vector3f centre_of(const Submesh& submesh, std::uint32_t id) {
  const auto& [a, b, c] = submesh.triangles[id];
  return (submesh.positions[a] + submesh.positions[b] + submesh.positions[c]) / 3;
}

/// Orders the ids so that the first half lies below the median of the longest axis; returns where the second starts.
std::size_t halve(const Submesh& submesh, TriangleIds ids) {
  Eigen::AlignedBox3f box;
  for (const auto id : ids) box.extend(centre_of(submesh, id));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = ids.begin() + static_cast<std::ptrdiff_t>(ids.size() / 2);
  std::nth_element(ids.begin(), middle, ids.end(), [&](std::uint32_t a, std::uint32_t b) {
    const float pa = centre_of(submesh, a)[axis], pb = centre_of(submesh, b)[axis];
    return pa != pb ? pa < pb : a < b;
  });
  return ids.size() / 2;
}

/// Pieces of one submesh. Keeps the order of its triangles and vertices; costs as much as the piece is large.
class Pieces {
 public:
  explicit Pieces(const Submesh& submesh) : submesh_{submesh}, new_index_(submesh.positions.size()) {}

  Submesh make(TriangleIds ids) {
    std::sort(ids.begin(), ids.end());
    std::vector<std::uint32_t> used;
    used.reserve(3 * ids.size());
    for (const auto id : ids) used.insert(used.end(), submesh_.triangles[id].begin(), submesh_.triangles[id].end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    Submesh piece;
    piece.texture = submesh_.texture;
    piece.positions.reserve(used.size());
    for (const auto index : used) {
      new_index_[index] = static_cast<std::uint32_t>(piece.positions.size());
      piece.positions.push_back(submesh_.positions[index]);
      if (submesh_.has_colors()) piece.colors.push_back(submesh_.colors[index]);
    }
    piece.triangles.reserve(ids.size());
    for (const auto id : ids) {
      const auto& [a, b, c] = submesh_.triangles[id];
      piece.triangles.push_back({new_index_[a], new_index_[b], new_index_[c]});
    }
    return piece;
  }

 private:
  const Submesh& submesh_;
  std::vector<std::uint32_t> new_index_;
};

/// What hangs together by vertices in one place, with at least so many triangles, is a thing; of more than the largest
/// few the rest is surroundings.
constexpr std::size_t kLeastOfThing = 500;
constexpr std::size_t kMostThings = 32;

/// For each triangle the first vertex of what it hangs together with.
std::vector<std::uint32_t> components_of(const Submesh& submesh) {
  std::vector<std::uint32_t> by_place(submesh.positions.size());
  std::iota(by_place.begin(), by_place.end(), 0U);
  const auto coordinates = [&](std::uint32_t i) {
    const auto& p = submesh.positions[i];
    return std::array{p.x(), p.y(), p.z()};
  };
  std::sort(by_place.begin(), by_place.end(),
            [&](std::uint32_t a, std::uint32_t b) { return coordinates(a) < coordinates(b); });
  Connected connected{submesh.positions.size()};
  for (std::size_t i = 1; i < by_place.size(); ++i) {
    if (coordinates(by_place[i - 1]) == coordinates(by_place[i])) connected.join(by_place[i - 1], by_place[i]);
  }
  for (const auto& [a, b, c] : submesh.triangles) {
    connected.join(a, b);
    connected.join(b, c);
  }
  std::vector<std::uint32_t> component;
  component.reserve(submesh.triangles.size());
  for (const auto& triangle : submesh.triangles) component.push_back(connected.first_of(triangle[0]));
  return component;
}

/// Triangles of the things that fit into one piece, each on its own, and all the others.
struct Things {
  std::vector<std::vector<std::uint32_t>> things;
  std::vector<std::uint32_t> others;
};

Things things_of(const Submesh& submesh, std::size_t max_triangles) {
  const auto component = components_of(submesh);
  std::vector<std::vector<std::uint32_t>> members(submesh.positions.size());
  for (std::uint32_t t = 0; t < component.size(); ++t) members[component[t]].push_back(t);
  Things found;
  for (auto& triangles : members) {
    if (triangles.size() >= kLeastOfThing && triangles.size() <= max_triangles)
      found.things.push_back(std::move(triangles));
    else
      found.others.insert(found.others.end(), triangles.begin(), triangles.end());
  }
  std::stable_sort(found.things.begin(), found.things.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  for (; found.things.size() > kMostThings; found.things.pop_back()) {
    const auto& triangles = found.things.back();
    found.others.insert(found.others.end(), triangles.begin(), triangles.end());
  }
  return found;
}

}  // namespace

std::vector<Submesh> split(const Submesh& submesh, std::size_t max_triangles) {
  const std::size_t limit = std::max<std::size_t>(max_triangles, 1);
  if (submesh.triangles.size() <= limit) return {submesh};
  auto [things, others] = things_of(submesh, limit);
  std::vector<Submesh> pieces;
  Pieces maker{submesh};
  for (auto& thing : things) pieces.push_back(maker.make(thing));
  std::vector<TriangleIds> open;
  if (!others.empty()) open.push_back(others);
  while (!open.empty()) {
    const TriangleIds group = open.back();
    open.pop_back();
    if (group.size() <= limit) {
      pieces.push_back(maker.make(group));
      continue;
    }
    const auto second = halve(submesh, group);
    open.push_back(group.subspan(second));
    open.push_back(group.first(second));
  }
  return pieces;
}

}  // namespace meshloop
