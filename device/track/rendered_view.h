#pragma once
// The model as the camera should see it from a pose, and what a pixel of that picture is in the world.
#include <Eigen/Core>
#include <optional>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/gpu/scene_renderer.h"
#include "common/image/image.h"
#include "common/mesh/model.h"

namespace meshloop {

struct RenderedView {
  Camera camera;
  Pose T_camera_world = Pose::Identity();
  /// Metres along the optical axis; 0 where no surface is.
  DepthImage depth;
  /// The model's colours as grey, and their local contrast (128 where it has none).
  GreyImage grey;
  GreyImage contrast;
  /// 255 where a coloured surface is.
  GreyImage colored;
  /// Share of the pixels that show a coloured surface.
  double colored_share = 0;
};

[[nodiscard]] RenderedView render_view(SceneRenderer& renderer, const Model& model, const Camera& camera,
                                       const Pose& T_camera_world);

/// Depth at a pixel between pixel centres; nothing at the border, where no surface is, and near a depth edge (when the
/// 5x5 neighbourhood's depths differ by more than a few percent beyond what a slanted plane explains).
[[nodiscard]] std::optional<double> steady_depth(const DepthImage& depth, const Eigen::Vector2d& pixel);

/// The world point that the view shows at a pixel, where its depth is steady.
[[nodiscard]] std::optional<Eigen::Vector3d> world_point(const RenderedView& view, const Eigen::Vector2d& pixel);

/// A pixel of another pose's picture, found in the view: where the view shows what that camera sees at `pixel`. The
/// poses are nearly equal. Saves drawing the model once more after a small correction.
[[nodiscard]] std::optional<Eigen::Vector2d> pixel_in_view(const RenderedView& view, const Pose& T_other_world,
                                                           const Eigen::Vector2d& pixel);

/// 255 where corners may be looked for: coloured surface, not within `margin_px` of its outline.
[[nodiscard]] GreyImage corner_mask(const RenderedView& view, int margin_px);

}  // namespace meshloop
