#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "server/adjust/open_border.h"

namespace meshloop::adjust {

/// Neighbours along the patch's border.
class PatchBorder {
 public:
  /// Directed edges; no vertex begins or ends two of them (split_vertices).
  explicit PatchBorder(const std::vector<std::array<std::uint32_t, 2>>& edges) {
    for (const auto& [from, to] : edges) link(from, to);
  }

  /// kNoVertex at an end.
  [[nodiscard]] std::uint32_t next(std::uint32_t vertex) const { return find(next_, vertex); }
  [[nodiscard]] std::uint32_t previous(std::uint32_t vertex) const { return find(previous_, vertex); }
  void link(std::uint32_t from, std::uint32_t to) {
    next_[from] = to;
    previous_[to] = from;
  }

  /// Vertices in the order of the border: each line once, closed ones from anywhere.
  [[nodiscard]] std::vector<std::vector<std::uint32_t>> lines() const;

  /// Takes out all that lies between two vertices of one line.
  void unlink(std::uint32_t from, std::uint32_t to) {
    for (auto v = from; v != to && v != kNoVertex;) {
      const auto after = next(v);
      next_.erase(v);
      previous_.erase(after);
      v = after;
    }
  }

 private:
  using Links = std::map<std::uint32_t, std::uint32_t>;

  static std::uint32_t find(const Links& links, std::uint32_t vertex) {
    const auto found = links.find(vertex);
    return found == links.end() ? kNoVertex : found->second;
  }

  Links next_;
  Links previous_;
};

}  // namespace meshloop::adjust
