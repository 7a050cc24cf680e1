#include "server/adjust/split_vertices.h"

#include <algorithm>
#include <map>

namespace meshloop::adjust {
namespace {

/// Triangles around a vertex that share edges, from one border to the next.
struct Fan {
  std::vector<std::uint32_t> triangles;
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

/// The corners of a triangle after this one.
std::array<std::uint32_t, 2> others(const Triangle& t, std::uint32_t vertex) {
  if (t[0] == vertex) return {t[1], t[2]};
  return t[1] == vertex ? std::array{t[2], t[0]} : std::array{t[0], t[1]};
}

std::vector<Fan> fans_of(const Submesh& submesh, std::uint32_t vertex, const std::vector<std::uint32_t>& triangles) {
  std::map<std::uint32_t, std::uint32_t> by_first;
  std::map<std::uint32_t, std::uint32_t> by_last;
  for (const auto t : triangles) {
    const auto [first, last] = others(submesh.triangles[t], vertex);
    by_first[first] = t;
    by_last[last] = t;
  }
  std::vector<Fan> fans;
  for (const auto& [first, triangle] : by_first) {
    if (by_last.contains(first)) continue;  // within a fan
    Fan fan{{}, first, first};
    for (auto next = by_first.find(first); next != by_first.end(); next = by_first.find(fan.last)) {
      fan.triangles.push_back(next->second);
      fan.last = others(submesh.triangles[next->second], vertex)[1];
    }
    fans.push_back(std::move(fan));
  }
  return fans;
}

}  // namespace

void split_vertices(Submesh& submesh, std::vector<std::array<std::uint32_t, 2>>& border) {
  std::map<std::uint32_t, int> ways_out;
  for (const auto& edge : border) ++ways_out[edge[0]];
  std::map<std::uint32_t, std::vector<std::uint32_t>> triangles_of;
  std::vector<bool> is_meeting(submesh.positions.size(), false);
  for (const auto& [vertex, count] : ways_out) is_meeting[vertex] = count > 1;
  for (std::uint32_t t = 0; t < submesh.triangles.size(); ++t) {
    for (const auto i : submesh.triangles[t]) {
      if (is_meeting[i]) triangles_of[i].push_back(t);
    }
  }
  for (const auto& [vertex, triangles] : triangles_of) {
    const auto fans = fans_of(submesh, vertex, triangles);
    for (std::size_t f = 1; f < fans.size(); ++f) {
      const auto copy = static_cast<std::uint32_t>(submesh.positions.size());
      submesh.positions.push_back(submesh.positions[vertex]);
      if (submesh.has_colors()) submesh.colors.push_back(submesh.colors[vertex]);
      for (const auto t : fans[f].triangles)
        std::replace(submesh.triangles[t].begin(), submesh.triangles[t].end(), vertex, copy);
      for (auto& [from, to] : border) {
        if (from == vertex && to == fans[f].first) from = copy;
        if (to == vertex && from == fans[f].last) to = copy;
      }
    }
  }
}

}  // namespace meshloop::adjust
