#pragma once
// Corners followed through the colour images, each with the place in the world that the rig's depth gave it. Used
// inside this stage; one thread.
#include <optional>
#include <vector>

#include "common/features/robust_pose.h"
#include "common/geometry/rig.h"
#include "common/image/image.h"
#include "server/track/depth_in_color.h"

namespace meshloop {

class FeatureSet {
 public:
  explicit FeatureSet(const Rig& rig) : rig_{rig} {}

  /// Observations in `image` of those features that could be followed there from the reference image, their own noise
  /// and their depth's included. `predicted`: T_color_world to start the search from.
  struct Sightings {
    std::vector<PointObservation> points;
    /// Positions of these in the set.
    std::vector<std::size_t> feature;
  };
  [[nodiscard]] Sightings follow(const GreyImage& image, const std::optional<Pose>& predicted) const;

  /// What the world points' own error, which all features born together share, adds to a pose found from them.
  [[nodiscard]] PoseCovariance birth_covariance(const Sightings& sightings, const std::vector<bool>& inlier,
                                                const Pose& T_color_world) const;

  /// Keeps the sightings that fit the pose and drops all others. True when `image` became the reference to follow from:
  /// each change of it adds to the drift, so one serves for several frames.
  [[nodiscard]] bool keep(const GreyImage& image, const Sightings& sightings, const Pose& T_color_world);
  /// Adds corners of the reference where there is room and depth; they inherit the covariance of its pose.
  void add(const DepthInColor& depth, const Pose& T_color_world, const PoseCovariance& covariance);
  void clear();

  [[nodiscard]] std::size_t size() const { return features_.size(); }

 private:
  struct Feature {
    /// In the reference image.
    Eigen::Vector2d pixel;
    Eigen::Vector3d p_world;
    /// One standard deviation of the depth it was born with, along the ray of its birth.
    Eigen::Vector3d depth_sigma_world;
    PoseCovariance birth_covariance_world;
    /// Changes of the reference since.
    int age = 0;
  };
  [[nodiscard]] double sigma_px(const Feature& feature, const Pose& T_color_world) const;

  Rig rig_;
  /// The reference.
  GreyImage image_;
  std::size_t at_reference_ = 0;
  int frames_from_reference_ = 0;
  std::vector<Feature> features_;
};

}  // namespace meshloop
