#pragma once
// Features that are followed from frame to frame, each with a world point that the model gave it once.
#include <Eigen/Core>
#include <vector>

#include "common/features/robust_pose.h"
#include "device/track/picture.h"
#include "device/track/rendered_view.h"

namespace meshloop {

struct Feature {
  /// In the newest frame.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
  /// Where the camera was when it was found.
  Eigen::Vector3d eye_world = Eigen::Vector3d::Zero();
  /// False while nothing but the model's depth speaks for its world point: the model's colours do not look like it
  /// there. It is followed, but does not bear on the pose.
  bool trusted = true;
  /// Frames in a row in which it contradicted the pose.
  int contradictions = 0;
};
using FeatureSet = std::vector<Feature>;

/// Follows the features into the next picture; those that are not found there are dropped. `prediction` gives the
/// starts.
[[nodiscard]] FeatureSet follow(const FeatureSet& features, const GreyImage& from, const GreyImage& to,
                                const Camera& camera, const Pose& prediction);

/// Without the features whose world point does not lie on the surface that the view shows (the model has changed, or
/// the point is hidden now).
[[nodiscard]] FeatureSet on_surface(const FeatureSet& features, const RenderedView& view);

/// Counts each feature's contradictions to the pose and drops those with too many. One that still agrees after the
/// camera has moved so far that a wrong depth would show is trusted from then on.
[[nodiscard]] FeatureSet judged(FeatureSet features, const Camera& camera, const Pose& T_camera_world);

/// Without what lies at stale places, and with new corners of the picture, up to `max_features`, whose world points
/// come from the view, from other places. A new one is trusted where the camera sees what the model shows, or the model
/// has no colours: what is not modelled, or was moved, looks different.
[[nodiscard]] FeatureSet replenished(FeatureSet features, const Picture& picture, const RenderedView& view,
                                     const Pose& T_camera_world, int max_features);

/// The trusted ones, for the solver.
[[nodiscard]] std::vector<PointObservation> observations_of(const FeatureSet& features, double sigma_px);
/// All of them, for a pose to begin with.
[[nodiscard]] std::vector<PointObservation> observations_of_all(const FeatureSet& features, double sigma_px);

}  // namespace meshloop
