#include "device/track/known_views.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "common/features/klt.h"

namespace meshloop {
namespace {

constexpr std::size_t kMostViews = 40;
constexpr double kApart_m = 0.08;
constexpr double kApart_rad = 0.12;
constexpr int kThumbnailWidth = 40;
constexpr int kThumbnailHeight = 30;
constexpr double kMinResemblance = 0.5;

GreyImage thumbnail_of(const GreyImage& grey) {
  const cv::Mat pixels{grey.height(), grey.width(), CV_8UC1, const_cast<std::uint8_t*>(grey.data())};
  GreyImage thumbnail{kThumbnailWidth, kThumbnailHeight};
  cv::Mat small{kThumbnailHeight, kThumbnailWidth, CV_8UC1, thumbnail.data()};
  cv::Mat blurred;
  cv::resize(pixels, blurred, small.size(), 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(blurred, small, {5, 5}, 1.2);
  return thumbnail;
}

double resemblance(const GreyImage& a, const GreyImage& b) {
  const cv::Mat first{a.height(), a.width(), CV_8UC1, const_cast<std::uint8_t*>(a.data())};
  const cv::Mat second{b.height(), b.width(), CV_8UC1, const_cast<std::uint8_t*>(b.data())};
  cv::Mat score;
  cv::matchTemplate(first, second, score, cv::TM_CCOEFF_NORMED);
  const double value = static_cast<double>(score.at<float>(0, 0));
  return std::isfinite(value) ? value : 0;
}

bool near(const Pose& a, const Pose& b) {
  const Twist apart = log(a * b.inverse());
  return (a.inverse().translation() - b.inverse().translation()).norm() < kApart_m &&
         apart.tail<3>().norm() < kApart_rad;
}

}  // namespace

void KnownViews::remember(const Pose& T_camera_world, const GreyImage& grey, const FeatureSet& features) {
  const bool known = std::any_of(views_.begin(), views_.end(),
                                 [&](const KnownView& view) { return near(view.T_camera_world, T_camera_world); });
  if (known) return;
  if (views_.size() >= kMostViews) views_.pop_front();
  views_.push_back({T_camera_world, grey, features, thumbnail_of(grey)});
}

std::vector<const KnownView*> KnownViews::similar_to(const GreyImage& grey, std::size_t count) const {
  const GreyImage thumbnail = thumbnail_of(grey);
  std::vector<std::pair<double, const KnownView*>> scored;
  for (const auto& view : views_) {
    const double score = resemblance(view.thumbnail, thumbnail);
    if (score >= kMinResemblance) scored.emplace_back(score, &view);
  }
  std::stable_sort(scored.begin(), scored.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<const KnownView*> best;
  for (const auto& [score, view] : scored) {
    if (best.size() < count) best.push_back(view);
  }
  return best;
}

std::optional<RobustPose> pose_from_view(const KnownView& view, const GreyImage& grey, const Camera& camera,
                                         int min_inliers) {
  FeatureSet features;
  std::copy_if(view.features.begin(), view.features.end(), std::back_inserter(features),
               [](const Feature& feature) { return feature.trusted; });
  std::vector<Eigen::Vector2d> pixels;
  for (const auto& feature : features) pixels.push_back(feature.pixel);
  FlowOptions flow;
  flow.window_px = 31;
  flow.pyramid_levels = 5;
  flow.max_round_trip_px = 1;
  const auto tracked = track_points(view.grey, grey, pixels, {}, flow);
  std::vector<PointObservation> observations;
  for (std::size_t i = 0; i < tracked.size(); ++i) {
    if (tracked[i].found) observations.push_back({features[i].p_world, tracked[i].pixel, 1});
  }
  RobustPoseOptions options;
  options.min_inliers = min_inliers;
  return find_pose(observations, camera, options);
}

}  // namespace meshloop
