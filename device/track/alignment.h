#pragma once
// The pose at which the picture agrees with the rendered model and with the features that were followed.
#include <optional>
#include <vector>

#include "device/track/absolute_match.h"
#include "device/track/edge_match.h"
#include "device/track/feature_set.h"
#include "device/track/picture.h"
#include "device/track/pose_solver.h"
#include "device/track/stale_places.h"

namespace meshloop {

/// Observations of one kind.
struct Votes {
  int found = 0;
  int agreeing = 0;
};

/// What a picture is held to.
struct Reference {
  SceneRenderer& renderer;
  const Model& model;
  const Camera& camera;
  /// What lies there has no say in the pose.
  const StalePlaces& stale;
};

struct Alignment {
  Pose T_camera_world = Pose::Identity();
  PoseCovariance covariance = PoseCovariance::Zero();
  /// Drawn at the pose of the last round, from which the result is only a small correction away.
  RenderedView view;
  /// The features that lie on the model's surface.
  FeatureSet features;
  Votes matches;
  Votes edges;
  Votes followed;
  /// Of what was found of the model, at stale places too.
  std::vector<Verdict> verdicts;

  /// Agreeing observations. Edges count a quarter: neighbours on one edge say nearly the same, and a step of brightness
  /// is found easily.
  [[nodiscard]] int inliers() const;
  /// Without the followed features, which agree with each other at a wrong pose too.
  [[nodiscard]] int inliers_on_model() const;
  /// Of what was found, the share that agrees with the pose; 0 when nothing was found.
  [[nodiscard]] double agreeing_share() const;
};

/// From a pose that is right to a few pixels: draws the model once, and once more when it was farther off than that.
[[nodiscard]] std::optional<Alignment> align_closely(const Reference& reference, const Picture& picture,
                                                     const Pose& start, const FeatureSet& features);

/// From a pose that is right to a few centimetres and degrees.
[[nodiscard]] std::optional<Alignment> align_widely(const Reference& reference, const Picture& picture,
                                                    const Pose& start);

}  // namespace meshloop
