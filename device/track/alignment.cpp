#include "device/track/alignment.h"

#include <algorithm>
#include <utility>

namespace meshloop {
namespace {

constexpr std::size_t kEnoughCorners = 24;
constexpr double kAgree_px = 2;
constexpr double kMaxError_px = 3;
/// The absolute matches hold the drift down; the followed features, being more precise from frame to frame, the jitter.
constexpr double kAbsoluteSigma_px = 0.7;
constexpr double kFeatureSigma_px = 0.7;

std::optional<RobustPose> solve(const Alignment& now, const Camera& camera, const Pose& start, bool rough,
                                int min_inliers) {
  RobustPoseOptions options;
  options.max_error_px = kMaxError_px;
  options.min_inliers = min_inliers;
  auto observations = observations_of(now.matches, kAbsoluteSigma_px);
  const auto followed = observations_of(now.features, kFeatureSigma_px);
  observations.insert(observations.end(), followed.begin(), followed.end());
  if (!rough) {
    if (auto pose = refine_pose(observations, camera, start, options)) return pose;
  }
  return find_pose(observations, camera, options);
}

}  // namespace

bool Alignment::has_absolute() const {
  return matches.size() >= kEnoughCorners;
}

double Alignment::agreeing_share() const {
  if (has_absolute()) return agreeing_matches / static_cast<double>(matches.size());
  if (features.empty()) return 0;
  return agreeing_features / static_cast<double>(features.size());
}

std::optional<Alignment> align(SceneRenderer& renderer, const Model& model, const Camera& camera,
                               const GreyImage& contrast, const Pose& start, const FeatureSet& features,
                               const AlignOptions& options) {
  Alignment now;
  now.pose.T_camera_world = start;
  AbsoluteSearch search = options.first_search;
  bool rough = options.rough_start;
  for (int round = 0; round < options.max_rounds; ++round) {
    now.view = render_view(renderer, model, camera, now.pose.T_camera_world);
    now.matches = match_view(now.view, contrast, search);
    now.features = on_surface(features, now.view);
    if (now.matches.empty() && now.features.empty()) break;
    auto pose = solve(now, camera, now.pose.T_camera_world, rough, options.min_inliers);
    if (!pose) return std::nullopt;
    now.pose = std::move(*pose);
    const bool settled = median_shift_px(now.matches) <= options.repeat_above_px;
    if (settled && !rough) break;
    search = AbsoluteSearch{};
    rough = false;
  }
  now.agreeing_matches = count_agreeing(now.matches, camera, now.pose.T_camera_world, kAgree_px);
  now.agreeing_features = count_agreeing(now.features, camera, now.pose.T_camera_world, kAgree_px);
  return now;
}

}  // namespace meshloop
