#include "server/adjust/border_match.h"

#include <algorithm>
#include <cmath>

namespace meshloop::adjust {
namespace {

struct Nearest {
  float share = 0;
  float distance2_px = 0;
  float depth_m = 0;
};

Nearest nearest_on_edge(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector2f& p) {
  const Eigen::Vector2f along = (b - a).head<2>();
  const float share = std::clamp((p - a.head<2>()).dot(along) / std::max(along.squaredNorm(), 1e-12f), 0.0f, 1.0f);
  return {share, (a.head<2>() + share * along - p).squaredNorm(), a.z() + share * (b.z() - a.z())};
}

}  // namespace

BorderLookup::BorderLookup(const OpenBorder& border, int width, int height, float reach_px)
    : border_{&border},
      reach_px_{reach_px},
      columns_{static_cast<int>(static_cast<float>(width) / reach_px) + 1},
      rows_{static_cast<int>(static_cast<float>(height) / reach_px) + 1},
      edges_of_cell_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
  for (std::uint32_t i = 0; i < border.size(); ++i) {
    if (border[i].next == kNoVertex) continue;
    const Eigen::Vector3f& a = border[i].in_picture;
    const Eigen::Vector3f& b = border[border[i].next].in_picture;
    if (!(a.z() > 0 && b.z() > 0)) continue;
    // One place in each cell and more, so that none is passed over.
    const float length_px = std::min((b - a).head<2>().norm(), 4.0f * static_cast<float>(width + height));
    const int steps = static_cast<int>(2 * length_px / reach_px) + 1;
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector2f p = (a + (b - a) * (static_cast<float>(k) / static_cast<float>(steps))).head<2>();
      if (!(p.x() >= 0 && p.y() >= 0 && p.x() < static_cast<float>(width) && p.y() < static_cast<float>(height)))
        continue;
      auto& cell = edges_of_cell_[static_cast<std::size_t>(static_cast<int>(p.y() / reach_px) * columns_ +
                                                           static_cast<int>(p.x() / reach_px))];
      if (cell.empty() || cell.back() != i) cell.push_back(i);
    }
  }
}

std::optional<BorderPlace> BorderLookup::find(const Eigen::Vector3f& in_picture, const Eigen::Vector2f& along,
                                              float depth_m) const {
  std::optional<BorderPlace> found;
  float best2 = reach_px_ * reach_px_;
  const int column = static_cast<int>(std::floor(in_picture.x() / reach_px_));
  const int row = static_cast<int>(std::floor(in_picture.y() / reach_px_));
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
      for (const auto i : edges_of_cell_[static_cast<std::size_t>(y * columns_ + x)]) {
        const Eigen::Vector3f& a = (*border_)[i].in_picture;
        const Eigen::Vector3f& b = (*border_)[(*border_)[i].next].in_picture;
        if ((b - a).head<2>().dot(along) >= 0) continue;
        const auto nearest = nearest_on_edge(a, b, in_picture.head<2>());
        if (nearest.distance2_px > best2 || std::abs(nearest.depth_m - in_picture.z()) > depth_m) continue;
        best2 = nearest.distance2_px;
        found = BorderPlace{i, nearest.share};
      }
    }
  }
  return found;
}

std::optional<std::vector<std::uint32_t>> vertices_between(const OpenBorder& border, const BorderPlace& first,
                                                           const BorderPlace& last, std::size_t most) {
  // An end of an edge that is this near counts as between, so that short edges are never left open.
  constexpr float kNear_px = 1.5f;
  const auto is_near = [&](std::uint32_t end, const BorderPlace& place) {
    const Eigen::Vector3f& a = border[place.vertex].in_picture;
    const Eigen::Vector3f& b = border[border[place.vertex].next].in_picture;
    return (a + place.share * (b - a) - border[end].in_picture).head<2>().norm() <= kNear_px;
  };
  std::vector<std::uint32_t> between;
  if (last.share < 0.5f && is_near(last.vertex, last)) between.push_back(last.vertex);
  std::uint32_t v = last.vertex;
  while (v != first.vertex) {
    v = border[v].next;
    if (v == kNoVertex || between.size() > most) return std::nullopt;
    between.push_back(v);
  }
  const auto end = border[first.vertex].next;
  const bool is_last_edge = first.vertex == last.vertex;
  if (first.share >= 0.5f && (!is_last_edge || first.share >= last.share) && is_near(end, first))
    between.push_back(end);
  std::reverse(between.begin(), between.end());
  return between;
}

}  // namespace meshloop::adjust
