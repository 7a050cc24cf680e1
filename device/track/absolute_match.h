#pragma once
// Corners of the rendered model, found in the camera's picture.
#include <Eigen/Core>
#include <vector>

#include "common/features/robust_pose.h"
#include "device/track/rendered_view.h"

namespace meshloop {

struct AbsoluteSearch {
  int max_corners = 220;
  int window_px = 15;
  int pyramid_levels = 2;
  /// A corner that moved farther than this was not found.
  double max_shift_px = 12;
  /// Correlation of the two patches from which on they show the same.
  double min_similarity = 0.6;
};
/// For a pose that is only roughly known.
[[nodiscard]] AbsoluteSearch wide_search();

struct AbsoluteMatch {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  /// In the view.
  Eigen::Vector2d expected = Eigen::Vector2d::Zero();
  /// In the camera's picture; meaningless when not found.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool found = false;
};

/// Correlation (-1 to 1) of two square patches; 0 when one leaves its picture or is flat.
[[nodiscard]] double patch_similarity(const GreyImage& a, const Eigen::Vector2d& pixel_a, const GreyImage& b,
                                      const Eigen::Vector2d& pixel_b, int radius_px);

/// One match for each corner that was looked for. `contrast` is local_contrast of the camera's picture.
[[nodiscard]] std::vector<AbsoluteMatch> match_view(const RenderedView& view, const GreyImage& contrast,
                                                    const AbsoluteSearch& search);

/// The found ones, for the solver.
[[nodiscard]] std::vector<PointObservation> observations_of(const std::vector<AbsoluteMatch>& matches, double sigma_px);

}  // namespace meshloop
