#pragma once
// The pose at which the picture agrees with the rendered model and with the features that were followed.
#include <optional>
#include <vector>

#include "device/track/absolute_match.h"
#include "device/track/feature_set.h"

namespace meshloop {

struct AlignOptions {
  /// How far the first round looks; later rounds are fine.
  AbsoluteSearch first_search;
  /// Draws the model once more when the picture was farther than this from the rendered one.
  double repeat_above_px = 3;
  int max_rounds = 2;
  /// The start may be far off: no trust in it beyond finding the matches.
  bool rough_start = false;
  int min_inliers = 15;
};

struct Alignment {
  RobustPose pose;
  /// Drawn at the pose of the last round, from which `pose` is only a small correction away.
  RenderedView view;
  std::vector<AbsoluteMatch> matches;
  /// The features that lie on the model's surface.
  FeatureSet features;
  int agreeing_matches = 0;
  int agreeing_features = 0;

  /// Enough of the model's corners are in sight to judge the pose by them.
  [[nodiscard]] bool has_absolute() const;
  /// Of the model's corners in sight, or (without these) of the features.
  [[nodiscard]] double agreeing_share() const;
};

/// Nothing when too little agrees. With neither colours in the model nor features there is nothing to align to: the
/// start is then the result, with no inliers.
[[nodiscard]] std::optional<Alignment> align(SceneRenderer& renderer, const Model& model, const Camera& camera,
                                             const GreyImage& contrast, const Pose& start, const FeatureSet& features,
                                             const AlignOptions& options);

}  // namespace meshloop
