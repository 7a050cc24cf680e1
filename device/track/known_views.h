#pragma once
// Pictures whose pose is known, for finding back after the track was lost.
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "device/track/feature_set.h"

namespace meshloop {

struct KnownView {
  Pose T_camera_world = Pose::Identity();
  GreyImage grey;
  FeatureSet features;
  /// Tiny and blurred, for telling at a glance which view a picture resembles.
  GreyImage thumbnail;
};

/// Keeps at most 40 views (the oldest goes), none near another.
class KnownViews {
 public:
  /// Does nothing when a view from nearly the same pose is known already.
  void remember(const Pose& T_camera_world, const GreyImage& grey, const FeatureSet& features);
  /// The `count` views that look most like the picture, best first; none that looks too different.
  [[nodiscard]] std::vector<const KnownView*> similar_to(const GreyImage& grey, std::size_t count) const;

 private:
  std::deque<KnownView> views_;
};

/// The pose of a picture from features that it shares with a known view; nothing when too few agree.
[[nodiscard]] std::optional<RobustPose> pose_from_view(const KnownView& view, const GreyImage& grey,
                                                       const Camera& camera, int min_inliers);

}  // namespace meshloop
