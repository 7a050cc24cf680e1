#include "server/track/feature_set.h"

#include <cmath>

#include "common/features/klt.h"
#include "server/track/covariance_frames.h"
#include "server/track/depth_in_color.h"

namespace meshloop {
namespace {

constexpr int kWanted = 400;
// Of a followed corner against where it was found, and what each change of the reference adds to it (a random walk).
constexpr double kFlowSigmaPx = 0.25;
constexpr double kFlowWalkPx = 0.05;
constexpr double kFittingPx = 3;
// The reference moves on after this many frames, or when less than this share of its features is left.
constexpr int kFramesFromReference = 5;
constexpr double kEnoughShare = 0.7;
constexpr double kNearest_m = 0.05;

GreyImage measured(const DepthInColor& depth) {
  GreyImage mask{depth.nearest.width(), depth.nearest.height()};
  for (std::size_t i = 0; i < mask.size(); ++i) mask.pixels()[i] = depth.nearest.pixels()[i].z > 0 ? 1 : 0;
  return mask;
}

}  // namespace

FeatureSet::Sightings FeatureSet::follow(const GreyImage& image, const std::optional<Pose>& predicted) const {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector2d> guesses;
  for (const Feature& feature : features_) {
    pixels.push_back(feature.pixel);
    if (!predicted) continue;
    const Eigen::Vector3d p = *predicted * feature.p_world;
    const bool usable = p.z() > kNearest_m && rig_.color.contains(rig_.color.project(p));
    guesses.push_back(usable ? rig_.color.project(p) : feature.pixel);
  }
  const auto tracked = track_points(image_, image, pixels, guesses, flow_options_for(image.width()));
  Sightings sightings;
  for (std::size_t i = 0; i < tracked.size(); ++i) {
    if (!tracked[i].found) continue;
    const double sigma = predicted ? sigma_px(features_[i], *predicted) : kFlowSigmaPx;
    sightings.points.push_back({features_[i].p_world, tracked[i].pixel, sigma});
    sightings.feature.push_back(i);
  }
  return sightings;
}

double FeatureSet::sigma_px(const Feature& feature, const Pose& T_color_world) const {
  const Eigen::Vector3d p = T_color_world * feature.p_world;
  const Eigen::Vector3d off = p + T_color_world.linear() * feature.depth_sigma_world;
  double depth_px = 0;
  if (p.z() > kNearest_m && off.z() > kNearest_m) depth_px = (rig_.color.project(off) - rig_.color.project(p)).norm();
  return std::sqrt(kFlowSigmaPx * kFlowSigmaPx + kFlowWalkPx * kFlowWalkPx * feature.age + depth_px * depth_px);
}

PoseCovariance FeatureSet::birth_covariance(const Sightings& sightings, const std::vector<bool>& inlier,
                                            const Pose& T_color_world) const {
  PoseCovariance mean = PoseCovariance::Zero();
  int count = 0;
  for (std::size_t i = 0; i < sightings.feature.size(); ++i) {
    if (!inlier[i]) continue;
    mean += features_[sightings.feature[i]].birth_covariance_world;
    ++count;
  }
  if (count == 0) return mean;
  return moved(T_color_world, mean / count);
}

bool FeatureSet::keep(const GreyImage& image, const Sightings& sightings, const Pose& T_color_world) {
  std::vector<Feature> fitting;
  std::vector<Eigen::Vector2d> pixels;
  for (std::size_t i = 0; i < sightings.points.size(); ++i) {
    const PointObservation& seen = sightings.points[i];
    const Eigen::Vector3d p = T_color_world * seen.p_world;
    if (p.z() < kNearest_m || (rig_.color.project(p) - seen.pixel).norm() > kFittingPx) continue;
    fitting.push_back(features_[sightings.feature[i]]);
    pixels.push_back(seen.pixel);
  }
  const bool enough = static_cast<double>(fitting.size()) >= kEnoughShare * static_cast<double>(at_reference_);
  features_ = std::move(fitting);
  if (at_reference_ > 0 && enough && ++frames_from_reference_ < kFramesFromReference) return false;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    features_[i].pixel = pixels[i];
    ++features_[i].age;
  }
  image_ = image;
  at_reference_ = features_.size();
  frames_from_reference_ = 0;
  return true;
}

void FeatureSet::add(const DepthInColor& depth, const Pose& T_color_world, const PoseCovariance& covariance) {
  if (image_.empty()) return;
  std::vector<Eigen::Vector2d> taken;
  for (const Feature& feature : features_) taken.push_back(feature.pixel);
  CornerOptions options = corner_options_for(image_.width());
  options.max_corners = kWanted - static_cast<int>(features_.size());
  const Pose T_world_color = T_color_world.inverse();
  const PoseCovariance in_world = moved(T_world_color, covariance);
  for (const Eigen::Vector2d& pixel : find_corners(image_, measured(depth), taken, options)) {
    const auto z = surface_depth_at(depth, pixel, rig_.sensor);
    if (!z || *z < kNearest_m) continue;
    const Eigen::Vector3d p_color = rig_.color.back_project(pixel.x(), pixel.y(), *z);
    const Eigen::Vector3d along = p_color / *z * rig_.sensor.sigma_z_m(*z, 0);
    features_.push_back({pixel, T_world_color * p_color, T_world_color.linear() * along, in_world, 0});
  }
  at_reference_ = features_.size();
}

void FeatureSet::clear() {
  features_.clear();
  image_ = {};
  at_reference_ = 0;
}

}  // namespace meshloop
