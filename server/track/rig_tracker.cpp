#include "server/track/rig_tracker.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/features/markers.h"
#include "server/track/covariance_frames.h"
#include "server/track/depth_in_color.h"
#include "server/track/feature_set.h"

namespace meshloop {
namespace {

// Of a first pose that was given: a millimetre and a milliradian.
constexpr double kGivenVariance = 1e-6;
constexpr int kLeastInliers = 12;
// Fewer of the followed features than this agree by chance, or because something large moves.
constexpr double kLeastAgreement = 0.4;
constexpr double kLargestSpread_m = 0.03;
constexpr double kLargestErrorPx = 3;
constexpr int kFramesUntilForgotten = 10;
// Neighbouring corners change their looks alike, so their errors are not independent: no more than this many count.
constexpr double kIndependent = 50;
// One marker alone is believed when the camera's place is this certain.
constexpr double kCertain_m = 0.005;
// Chi-square with 6 degrees of freedom, 99.9 %.
constexpr double kSamePose = 22.5;
constexpr double kLongestPrediction_s = 0.5;

double spread_m(const PoseCovariance& covariance) {
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>{covariance.topLeftCorner<3, 3>()}.eigenvalues().maxCoeff());
}

struct Estimate {
  Pose T_color_world = Pose::Identity();
  PoseCovariance covariance = PoseCovariance::Zero();
  int inliers = 0;
  double quality = 0;
};

Estimate to_estimate(const RobustPose& pose, std::size_t observations) {
  return {pose.T_camera_world, pose.covariance, pose.inliers,
          observations == 0 ? 0.0 : pose.inliers / static_cast<double>(observations)};
}

class MarkerAndFeatureTracker final : public RigTracker {
 public:
  MarkerAndFeatureTracker(const Rig& rig, const RigTrackerOptions& options, std::optional<MarkerDetector> detector)
      : rig_{rig},
        map_{options.markers},
        first_pose_{options.first_pose},
        detector_{std::move(detector)},
        features_{rig} {}

  TrackedPose track(const RgbdFrame& frame) override;

 private:
  [[nodiscard]] std::optional<Pose> predict(double timestamp_s) const;
  [[nodiscard]] std::optional<Estimate> from_markers(const std::vector<MarkerSighting>& seen,
                                                     const FeatureSet::Sightings& features,
                                                     const std::optional<Pose>& predicted) const;
  [[nodiscard]] std::optional<Estimate> from_features(const FeatureSet::Sightings& sightings,
                                                      const std::optional<Pose>& predicted) const;
  [[nodiscard]] Estimate joint(const Estimate& markers, const std::vector<MarkerSighting>& seen,
                               const FeatureSet::Sightings& features) const;
  [[nodiscard]] Pose color_from_depth(const RgbdFrame& frame, const Pose& T_color_world) const;
  TrackedPose found(const RgbdFrame& frame, const GreyImage& grey, const FeatureSet::Sightings& sightings,
                    const Estimate& estimate);
  TrackedPose lost(double timestamp_s);

  Rig rig_;
  std::optional<MarkerMap> map_;
  std::optional<Pose> first_pose_;
  std::optional<MarkerDetector> detector_;
  FeatureSet features_;
  /// The last pose that was found, and the one just before it if it was found too.
  std::optional<TrackedPose> last_;
  std::optional<TrackedPose> before_last_;
  int frames_lost_ = 0;
};

TrackedPose MarkerAndFeatureTracker::track(const RgbdFrame& frame) {
  if (frame.color.width() != rig_.color.width || frame.color.height() != rig_.color.height) {
    return lost(frame.color_timestamp_s);
  }
  const GreyImage grey = to_grey(frame.color);
  const std::optional<Pose> predicted = predict(frame.color_timestamp_s);
  const FeatureSet::Sightings sightings = features_.follow(grey, predicted);
  std::optional<Estimate> estimate;
  if (detector_) estimate = from_markers(detector_->detect(grey), sightings, predicted);
  if (!estimate) estimate = from_features(sightings, predicted);
  if (!estimate && first_pose_) {
    estimate = Estimate{*first_pose_, PoseCovariance::Identity() * kGivenVariance, 0, 1};
  }
  const bool started_as_told = first_pose_ && estimate && estimate->inliers == 0;
  first_pose_.reset();
  if (!estimate) return lost(frame.color_timestamp_s);
  TrackedPose pose = found(frame, grey, sightings, *estimate);
  if (started_as_told) {
    pose.state = last_->state = TrackState::tracking;
    pose.inliers = last_->inliers = static_cast<int>(features_.size());
  }
  return pose;
}

// With the velocity between the last two poses; without one where the rig stood. Nothing once lost.
std::optional<Pose> MarkerAndFeatureTracker::predict(double timestamp_s) const {
  if (!last_ || frames_lost_ > 0) return std::nullopt;
  if (!before_last_) return last_->T_camera_world;
  const double known_s = last_->timestamp_s - before_last_->timestamp_s;
  const double ahead_s = timestamp_s - last_->timestamp_s;
  if (!(known_s > 0) || !(ahead_s > 0) || ahead_s > kLongestPrediction_s) return last_->T_camera_world;
  return interpolate(before_last_->T_camera_world, last_->T_camera_world, 1 + ahead_s / known_s);
}

std::optional<Estimate> MarkerAndFeatureTracker::from_markers(const std::vector<MarkerSighting>& seen,
                                                              const FeatureSet::Sightings& features,
                                                              const std::optional<Pose>& predicted) const {
  const auto pose = pose_from_markers(seen, *map_, rig_.color, predicted);
  if (!pose) return std::nullopt;
  const Estimate markers = to_estimate(*pose, pose->inlier.size());
  if (pose->inliers >= 8 || spread_m(pose->covariance) < kCertain_m) return markers;
  return joint(markers, seen, features);
}

// One marker that leaves a direction uncertain, helped by the features where both agree.
Estimate MarkerAndFeatureTracker::joint(const Estimate& markers, const std::vector<MarkerSighting>& seen,
                                        const FeatureSet::Sightings& features) const {
  std::vector<PointObservation> points = features.points;
  for (const MarkerSighting& sighting : seen) {
    for (const Marker& marker : map_->markers) {
      if (marker.id != sighting.id) continue;
      for (std::size_t k = 0; k < 4; ++k) points.push_back({marker.corners[k], sighting.pixels[k], sighting.sigma_px});
    }
  }
  const auto pose = refine_pose(points, rig_.color, markers.T_color_world, {kLargestErrorPx, kLeastInliers, 20});
  if (!pose) return markers;
  Estimate both = to_estimate(*pose, points.size());
  std::vector<bool> inlier{pose->inlier.begin(),
                           pose->inlier.begin() + static_cast<std::ptrdiff_t>(features.points.size())};
  both.covariance *= std::max(1.0, pose->inliers / kIndependent);
  both.covariance += features_.birth_covariance(features, inlier, both.T_color_world);
  if (both.covariance.trace() >= markers.covariance.trace()) return markers;
  const Twist apart = log(both.T_color_world * markers.T_color_world.inverse());
  const PoseCovariance spread = markers.covariance + both.covariance;
  return apart.dot(spread.ldlt().solve(apart)) < kSamePose ? both : markers;
}

std::optional<Estimate> MarkerAndFeatureTracker::from_features(const FeatureSet::Sightings& sightings,
                                                               const std::optional<Pose>& predicted) const {
  const RobustPoseOptions options{kLargestErrorPx, kLeastInliers, 20};
  const auto enough = [&](const RobustPose& pose) {
    return pose.inliers >= kLeastAgreement * static_cast<double>(sightings.points.size()) &&
           spread_m(pose.covariance) < kLargestSpread_m;
  };
  std::optional<RobustPose> pose;
  if (predicted) pose = refine_pose(sightings.points, rig_.color, *predicted, options);
  if (!pose || !enough(*pose)) pose = find_pose(sightings.points, rig_.color, options);
  if (!pose || !enough(*pose)) return std::nullopt;
  Estimate estimate = to_estimate(*pose, sightings.points.size());
  estimate.covariance *= std::max(1.0, pose->inliers / kIndependent);
  estimate.covariance += features_.birth_covariance(sightings, pose->inlier, pose->T_camera_world);
  return estimate;
}

// How the depth camera at its moment stands to the colour camera at its own: the rig moves between the two.
Pose MarkerAndFeatureTracker::color_from_depth(const RgbdFrame& frame, const Pose& T_color_world) const {
  const Pose T_color_depth = rig_.depth_registered ? Pose::Identity() : rig_.T_depth_color.inverse();
  if (!last_ || frames_lost_ > 0) return T_color_depth;
  const double distance_s = frame.color_timestamp_s - last_->timestamp_s;
  const double s = (frame.depth_timestamp_s - last_->timestamp_s) / distance_s;
  if (!(distance_s > 0) || !(s >= -0.5 && s <= 1.5)) return T_color_depth;
  const Pose at_depth_time = interpolate(last_->T_camera_world, T_color_world, s);
  return T_color_world * at_depth_time.inverse() * T_color_depth;
}

TrackedPose MarkerAndFeatureTracker::found(const RgbdFrame& frame, const GreyImage& grey,
                                           const FeatureSet::Sightings& sightings, const Estimate& estimate) {
  if (features_.keep(grey, sightings, estimate.T_color_world)) {
    features_.add(depth_in_color(rig_, frame.depth, color_from_depth(frame, estimate.T_color_world)),
                  estimate.T_color_world, estimate.covariance);
  }
  TrackedPose pose;
  pose.timestamp_s = frame.color_timestamp_s;
  pose.state = last_ && frames_lost_ == 0 ? TrackState::tracking : TrackState::relocalised;
  pose.T_camera_world = estimate.T_color_world;
  pose.covariance = estimate.covariance;
  pose.quality = estimate.quality;
  pose.inliers = estimate.inliers;
  // A colour image may come again with the next depth image: it says nothing about the velocity.
  if (pose.state != TrackState::tracking) {
    before_last_.reset();
  } else if (pose.timestamp_s > last_->timestamp_s) {
    before_last_ = last_;
  }
  last_ = pose;
  frames_lost_ = 0;
  return pose;
}

// The features stay as the last good frame had them: the view may return within a few frames.
TrackedPose MarkerAndFeatureTracker::lost(double timestamp_s) {
  before_last_.reset();
  if (++frames_lost_ > kFramesUntilForgotten) features_.clear();
  TrackedPose pose;
  pose.timestamp_s = timestamp_s;
  return pose;
}

}  // namespace

Result<std::unique_ptr<RigTracker>> RigTracker::create(const Rig& rig, const RigTrackerOptions& options) {
  if (const Status status = validate(rig); !status) return fail("tracking the rig", status.error());
  if (options.first_pose && !is_rigid(*options.first_pose)) {
    return fail("the first pose is not a rigid transform: give a finite translation and a unit quaternion",
                ErrorKind::usage);
  }
  const bool has_markers = options.markers && !options.markers->markers.empty();
  if (!has_markers && !options.first_pose) {
    return fail("tracking needs a start: give markers.yaml or the pose of the first frame", ErrorKind::usage);
  }
  std::optional<MarkerDetector> detector;
  if (has_markers) {
    auto created = MarkerDetector::create(options.markers->dictionary);
    if (!created) return fail(created.error());
    detector = std::move(*created);
  }
  return std::make_unique<MarkerAndFeatureTracker>(rig, options, std::move(detector));
}

}  // namespace meshloop
