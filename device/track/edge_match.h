#pragma once
// Edges of the model's shape, found in the camera's picture. They need no colours in the model, and no likeness of
// light: outlines and creases show as steps of brightness at the same place.
#include <vector>

#include "device/track/pose_solver.h"
#include "device/track/rendered_view.h"

namespace meshloop {

/// Where a row or a column of the view crosses an edge of the shape.
struct ModelEdge {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  /// In the view; the coordinate across the scan line is whole.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  /// 0: found along a row (x runs), 1: along a column.
  int axis = 0;
};

/// Outlines (the near side's border where the depth jumps, or ends) and creases (the inverse depth, linear on a plane,
/// has a kink), on every `spacing_px`-th row and column. Surfaces rougher than planes give none.
[[nodiscard]] std::vector<ModelEdge> find_model_edges(const RenderedView& view, int spacing_px);

struct EdgeSearch {
  /// To both sides.
  double reach_px = 6;
  /// Grey levels a pixel.
  double min_gradient = 5;
};

/// The nearest step of brightness to each edge, along the row or column that crosses it. Edges without one, and those
/// with two that are about equally near, are left out. `smooth` is the camera's picture, lightly blurred.
[[nodiscard]] std::vector<EdgeObservation> match_edges(const std::vector<ModelEdge>& edges, const GreyImage& smooth,
                                                       const EdgeSearch& search, double sigma_px);

}  // namespace meshloop
