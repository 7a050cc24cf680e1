#include "device/track/model_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "device/track/alignment.h"
#include "device/track/known_views.h"

namespace meshloop {
namespace {

constexpr double kMaxSpread_m = 0.05;
constexpr double kMaxSpread_rad = 0.05;
/// The share of the observations that must agree, to start and to go on for long.
constexpr double kShareToStart = 0.5;
constexpr double kShareToGoOn = 0.35;
constexpr int kMaxDoubtfulFrames = 5;
/// The share of what agreed on the model in the last frame that must agree on a new one.
constexpr double kShareToStay = 0.6;
/// A pose predicted over more frames than this is no better than the last one.
constexpr double kLongestPrediction = 3;
constexpr std::size_t kViewsToTry = 2;

struct TimedPose {
  double timestamp_s = 0;
  Pose T_camera_world = Pose::Identity();
};

/// Constant velocity.
Pose predict(const std::optional<TimedPose>& before, const TimedPose& last, double timestamp_s) {
  if (!before) return last.T_camera_world;
  const double step_s = last.timestamp_s - before->timestamp_s;
  const double ahead_s = timestamp_s - last.timestamp_s;
  if (!(step_s > 0) || !(ahead_s > 0) || ahead_s > kLongestPrediction * step_s) return last.T_camera_world;
  return interpolate(before->T_camera_world, last.T_camera_world, 1 + ahead_s / step_s);
}

bool is_certain(const PoseCovariance& covariance) {
  // Written so that a covariance that is not a number is refused.
  const double spread_m2 = covariance.topLeftCorner<3, 3>().trace();
  const double spread_rad2 = covariance.bottomRightCorner<3, 3>().trace();
  return spread_m2 < kMaxSpread_m * kMaxSpread_m && spread_rad2 < kMaxSpread_rad * kMaxSpread_rad;
}

FeatureSet on_probation(FeatureSet features) {
  std::erase_if(features, [](const Feature& feature) { return feature.trusted; });
  return features;
}

class FeatureModelTracker final : public ModelTracker {
 public:
  FeatureModelTracker(std::unique_ptr<SceneRenderer> renderer, const Camera& camera, const ModelTrackerOptions& options)
      : renderer_{std::move(renderer)}, camera_{camera.without_distortion()}, options_{options} {}

  void warm_up(const Model& model) override { (void)render_view(*renderer_, model, camera_, Pose::Identity()); }
  void start_at(const Pose& T_camera_world) override;
  TrackedPose track(const ColorFrame& frame, const std::shared_ptr<const Model>& model) override;

 private:
  [[nodiscard]] std::optional<Alignment> go_on(const Model& model, const Picture& picture, double timestamp_s);
  [[nodiscard]] std::optional<Pose> pose_of(const std::vector<PointObservation>& followed,
                                            const Pose& prediction) const;
  [[nodiscard]] std::vector<Pose> places_to_try(const Picture& picture, double timestamp_s) const;
  [[nodiscard]] std::optional<Alignment> recover(const Model& model, const Picture& picture, double timestamp_s);
  [[nodiscard]] Reference reference(const Model& model) const { return {*renderer_, model, camera_, stale_}; }
  [[nodiscard]] bool is_sure(const std::optional<Alignment>& found) const;
  /// For a new model: where it fits much better than at `found`, if it fits there much less than the old one did, as
  /// a pose does that was held by what is mended now.
  [[nodiscard]] std::optional<Alignment> found_elsewhere(const std::optional<Alignment>& found, const Model& model,
                                                         const Picture& picture);
  /// With a wide search in which everything has a say.
  [[nodiscard]] std::optional<Alignment> found_afresh(const Model& model, const Picture& picture,
                                                      const Pose& start) const;
  [[nodiscard]] std::optional<Alignment> found_from(const Model& model, const Picture& picture,
                                                    const Pose& start) const;
  [[nodiscard]] TrackedPose accept(Alignment found, Picture picture, double timestamp_s, TrackState state);
  TrackedPose lose(double timestamp_s);

  std::unique_ptr<SceneRenderer> renderer_;
  Camera camera_;
  ModelTrackerOptions options_;
  enum class Mode { idle, starting, tracking, lost };
  Mode mode_ = Mode::idle;
  /// The last pose that is known, and the one before it while there is a velocity.
  TimedPose last_;
  std::optional<TimedPose> before_;
  int last_inliers_on_model_ = 0;
  GreyImage last_grey_;
  FeatureSet features_;
  KnownViews known_views_;
  StalePlaces stale_;
  /// Of the last frame.
  std::shared_ptr<const Model> model_;
  int doubtful_frames_ = 0;
  /// Since the pose was lost.
  unsigned wide_searches_ = 0;
};

void FeatureModelTracker::start_at(const Pose& T_camera_world) {
  features_.clear();
  before_.reset();
  stale_.clear();
  doubtful_frames_ = 0;
  mode_ = is_rigid(T_camera_world) ? Mode::starting : Mode::idle;
  last_.T_camera_world = T_camera_world;
}

bool FeatureModelTracker::is_sure(const std::optional<Alignment>& found) const {
  return found && found->inliers() >= options_.min_inliers && found->agreeing_share() >= kShareToStart &&
         is_certain(found->covariance);
}

std::optional<Alignment> FeatureModelTracker::found_from(const Model& model, const Picture& picture,
                                                         const Pose& start) const {
  // The smallest correction that fits wins: a wide search also finds an object that was moved, and would follow it.
  if (auto found = align_closely(reference(model), picture, start, {}); is_sure(found)) return found;
  if (auto found = align_widely(reference(model), picture, start); is_sure(found)) return found;
  return std::nullopt;
}

std::optional<Alignment> FeatureModelTracker::found_elsewhere(const std::optional<Alignment>& found, const Model& model,
                                                              const Picture& picture) {
  const int agreeing = found ? found->inliers_on_model() : 0;
  if (agreeing >= kShareToStay * last_inliers_on_model_) return std::nullopt;
  auto elsewhere = found_afresh(model, picture, found ? found->T_camera_world : last_.T_camera_world);
  if (!elsewhere || elsewhere->inliers_on_model() <= agreeing) return std::nullopt;
  stale_.clear();
  return elsewhere;
}

std::optional<Alignment> FeatureModelTracker::found_afresh(const Model& model, const Picture& picture,
                                                           const Pose& start) const {
  const StalePlaces none;
  auto found = align_widely({*renderer_, model, camera_, none}, picture, start);
  return is_sure(found) ? std::move(found) : std::nullopt;
}

std::optional<Pose> FeatureModelTracker::pose_of(const std::vector<PointObservation>& followed,
                                                 const Pose& prediction) const {
  RobustPoseOptions options;
  options.min_inliers = options_.min_inliers;
  auto pose = refine_pose(followed, camera_, prediction, options);
  if (!pose) pose = find_pose(followed, camera_, options);
  if (!pose) return std::nullopt;
  return pose->T_camera_world;
}

std::optional<Alignment> FeatureModelTracker::go_on(const Model& model, const Picture& picture, double timestamp_s) {
  const Pose prediction = predict(before_, last_, timestamp_s);
  const FeatureSet followed = follow(features_, last_grey_, picture.grey, camera_, prediction);
  const auto trusted = pose_of(observations_of(followed, 1), prediction);
  // Too few to fix a pose are too few to tell a wrong one among them: the model alone has a say then, and the others
  // may say where to begin.
  const auto start = trusted ? trusted : pose_of(observations_of_all(followed, 1), prediction);
  std::optional<Alignment> found;
  if (start) {
    found = align_closely(reference(model), picture, *start, trusted ? followed : on_probation(followed));
    if (is_sure(found)) return found;
  }
  if (!trusted) return found_from(model, picture, prediction);
  // What is followed may lie on something that the model does not have; the model itself then says so.
  auto without = align_closely(reference(model), picture, prediction, {});
  return is_sure(without) ? without : found;
}

std::vector<Pose> FeatureModelTracker::places_to_try(const Picture& picture, double timestamp_s) const {
  std::vector<Pose> places{last_.T_camera_world};
  const Pose prediction = predict(before_, last_, timestamp_s);
  if (!prediction.isApprox(last_.T_camera_world)) places.push_back(prediction);
  for (const KnownView* view : known_views_.similar_to(picture.grey, kViewsToTry)) {
    const auto pose = pose_from_view(*view, picture.grey, camera_, options_.min_inliers);
    places.push_back(pose ? pose->T_camera_world : view->T_camera_world);
  }
  return places;
}

std::optional<Alignment> FeatureModelTracker::recover(const Model& model, const Picture& picture, double timestamp_s) {
  const std::vector<Pose> places = places_to_try(picture, timestamp_s);
  for (const Pose& place : places) {
    if (auto found = align_closely(reference(model), picture, place, {}); is_sure(found)) return found;
  }
  // A wide search takes as long as all of these: one for each frame, from another place each time.
  const Pose& place = places[wide_searches_++ % places.size()];
  auto found = found_afresh(model, picture, place);
  // They may be of a wrong pose.
  if (found) stale_.clear();
  return found;
}

TrackedPose FeatureModelTracker::lose(double timestamp_s) {
  // Having been started is worth keeping: the start may be right although this frame does not show it.
  if (mode_ != Mode::idle) mode_ = Mode::lost;
  features_.clear();
  doubtful_frames_ = 0;
  TrackedPose result;
  result.timestamp_s = timestamp_s;
  return result;
}

TrackedPose FeatureModelTracker::accept(Alignment found, Picture picture, double timestamp_s, TrackState state) {
  const Pose T_camera_world = found.T_camera_world;
  TrackedPose result;
  result.timestamp_s = timestamp_s;
  result.state = state;
  result.T_camera_world = T_camera_world;
  result.covariance = found.covariance;
  result.quality = found.agreeing_share();
  result.inliers = found.inliers();
  const int inliers_on_model = found.inliers_on_model();
  doubtful_frames_ = result.quality < kShareToGoOn ? doubtful_frames_ + 1 : 0;
  const bool doubtful = doubtful_frames_ > kMaxDoubtfulFrames;
  if (result.inliers < options_.min_inliers || !is_certain(result.covariance) || doubtful) return lose(timestamp_s);

  if (result.quality >= kShareToStart) stale_.judge(found.verdicts);
  features_ = judged(std::move(found.features), camera_, T_camera_world);
  features_ = replenished(std::move(features_), picture, found.view, T_camera_world, options_.max_features);
  if (mode_ == Mode::tracking && state == TrackState::tracking) {
    before_ = last_;
  } else {
    before_.reset();
  }
  mode_ = Mode::tracking;
  last_ = {timestamp_s, T_camera_world};
  last_inliers_on_model_ = inliers_on_model;
  last_grey_ = std::move(picture.grey);
  if (result.quality >= kShareToStart) known_views_.remember(T_camera_world, last_grey_, features_);
  return result;
}

TrackedPose FeatureModelTracker::track(const ColorFrame& frame, const std::shared_ptr<const Model>& model) {
  const bool fits = frame.color.width() == camera_.width && frame.color.height() == camera_.height;
  if (!fits || !model || model->nodes.empty() || mode_ == Mode::idle) return lose(frame.timestamp_s);
  const bool is_new = std::exchange(model_, model) != model;
  Picture picture{frame.color};
  std::optional<Alignment> found;
  TrackState state = TrackState::tracking;
  if (mode_ == Mode::starting) {
    found = found_from(*model, picture, last_.T_camera_world);
  } else if (mode_ == Mode::tracking) {
    found = go_on(*model, picture, frame.timestamp_s);
    if (auto elsewhere = is_new ? found_elsewhere(found, *model, picture) : std::nullopt) {
      found = std::move(elsewhere);
      state = TrackState::relocalised;
    }
    wide_searches_ = 0;
  } else {
    found = recover(*model, picture, frame.timestamp_s);
    state = TrackState::relocalised;
  }
  if (!found) return lose(frame.timestamp_s);
  return accept(std::move(*found), std::move(picture), frame.timestamp_s, state);
}

}  // namespace

Result<std::unique_ptr<ModelTracker>> ModelTracker::create(GpuContext& context, const Camera& camera,
                                                           const ModelTrackerOptions& options) {
  if (const auto checked = validate(camera); !checked) return fail("the tracker's camera", checked.error());
  if (options.max_features < options.min_inliers || options.min_inliers < 6) {
    return fail(fmt::format("the tracker needs at least 6 inliers and more features than inliers, not {} and {}",
                            options.min_inliers, options.max_features),
                ErrorKind::usage);
  }
  auto renderer = SceneRenderer::create(context);
  if (!renderer) return fail(renderer.error());
  return std::unique_ptr<ModelTracker>(std::make_unique<FeatureModelTracker>(std::move(*renderer), camera, options));
}

}  // namespace meshloop
