#pragma once
// Which vertices of a patch's border lie beside the model's open border.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/adjust/open_border.h"

namespace meshloop::adjust {

/// A point of a border edge: its first vertex, and the share of the way to the next.
struct BorderPlace {
  std::uint32_t vertex = kNoVertex;
  float share = 0;
};

/// Looks up the nearest place of the model's border.
class BorderLookup {
 public:
  /// Places in a picture of this size, up to `reach_px` away. The border must outlive this.
  BorderLookup(const OpenBorder& border, int width, int height, float reach_px);

  /// The nearest place of an edge that runs against `along` (in the picture), since that is how surfaces with the same
  /// front meet, and whose depth differs by this much at most.
  [[nodiscard]] std::optional<BorderPlace> find(const Eigen::Vector3f& in_picture, const Eigen::Vector2f& along,
                                                float depth_m) const;

 private:
  const OpenBorder* border_;
  float reach_px_;
  /// Edges by the cells of a grid over the picture that they pass through; cells as wide as the reach.
  int columns_;
  int rows_;
  std::vector<std::vector<std::uint32_t>> edges_of_cell_;
};

/// A border vertex of the patch, in the order of the border, and its place on the model's border.
struct Matched {
  std::uint32_t vertex = 0;
  BorderPlace place;
};

/// The model's border vertices between the places of two vertices of a stretch, in the order of the patch's border;
/// nothing when the places are not on one line of the border within `most` steps. The model's border runs the other
/// way.
[[nodiscard]] std::optional<std::vector<std::uint32_t>> vertices_between(const OpenBorder& border,
                                                                         const BorderPlace& first,
                                                                         const BorderPlace& last, std::size_t most);

}  // namespace meshloop::adjust
