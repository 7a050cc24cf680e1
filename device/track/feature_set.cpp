#include "device/track/feature_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/features/klt.h"
#include "device/track/absolute_match.h"

namespace meshloop {
namespace {

constexpr double kOffSurface_m = 0.01;
constexpr double kMaxError_px = 2;
constexpr int kMaxContradictions = 3;
/// A camera that moved by this share of the distance shows a depth that is 2 cm wrong at 1 m by more than a pixel.
constexpr double kProvenMove = 0.15;
constexpr double kProvenError_px = 0.8;
constexpr int kPatchRadius_px = 7;
constexpr double kMinSimilarity = 0.5;

std::optional<Eigen::Vector2d> projection(const Camera& camera, const Pose& T_camera_world,
                                          const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d p_camera = T_camera_world * p_world;
  if (p_camera.z() <= 0) return std::nullopt;
  return camera.project(p_camera);
}

double error_px(const Feature& feature, const Camera& camera, const Pose& T_camera_world) {
  const auto pixel = projection(camera, T_camera_world, feature.p_world);
  return pixel ? (*pixel - feature.pixel).norm() : std::numeric_limits<double>::infinity();
}

/// True where the model has no colours to compare with.
bool looks_as_modelled(const RenderedView& view, const Eigen::Vector2d& in_view, const GreyImage& contrast,
                       const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::lround(in_view.x()));
  const int y = static_cast<int>(std::lround(in_view.y()));
  if (x < 0 || y < 0 || x >= view.colored.width() || y >= view.colored.height()) return false;
  if (view.contrast.empty() || view.colored(x, y) == 0) return true;
  return patch_similarity(view.contrast, in_view, contrast, pixel, kPatchRadius_px) >= kMinSimilarity;
}

GreyImage surface_mask(const RenderedView& view) {
  GreyImage mask{view.depth.width(), view.depth.height()};
  std::transform(view.depth.pixels().begin(), view.depth.pixels().end(), mask.pixels().begin(),
                 [](float depth) { return depth > 0 ? std::uint8_t{255} : std::uint8_t{0}; });
  return mask;
}

}  // namespace

FeatureSet follow(const FeatureSet& features, const GreyImage& from, const GreyImage& to, const Camera& camera,
                  const Pose& prediction) {
  std::vector<Eigen::Vector2d> points;
  std::vector<Eigen::Vector2d> guesses;
  for (const auto& feature : features) {
    points.push_back(feature.pixel);
    const auto guess = projection(camera, prediction, feature.p_world);
    guesses.push_back(guess && camera.contains(*guess) ? *guess : feature.pixel);
  }
  const auto tracked = track_points(from, to, points, guesses, {});
  FeatureSet followed;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!tracked[i].found) continue;
    followed.push_back(features[i]);
    followed.back().pixel = tracked[i].pixel;
  }
  return followed;
}

FeatureSet on_surface(const FeatureSet& features, const RenderedView& view) {
  FeatureSet kept;
  for (const auto& feature : features) {
    const auto pixel = projection(view.camera, view.T_camera_world, feature.p_world);
    if (!pixel) continue;
    const auto depth = steady_depth(view.depth, *pixel);
    if (!depth) continue;
    const double off = std::abs(*depth - (view.T_camera_world * feature.p_world).z());
    if (off <= kOffSurface_m) kept.push_back(feature);
  }
  return kept;
}

FeatureSet judged(FeatureSet features, const Camera& camera, const Pose& T_camera_world) {
  const Eigen::Vector3d eye_world = T_camera_world.inverse().translation();
  for (auto& feature : features) {
    const double error = error_px(feature, camera, T_camera_world);
    feature.contradictions = error <= kMaxError_px ? 0 : feature.contradictions + 1;
    const double moved_m = (eye_world - feature.eye_world).norm();
    const double depth_m = (T_camera_world * feature.p_world).z();
    if (error <= kProvenError_px && moved_m >= kProvenMove * depth_m) feature.trusted = true;
  }
  std::erase_if(features, [](const Feature& feature) {
    return feature.contradictions >= (feature.trusted ? kMaxContradictions : 1);
  });
  return features;
}

FeatureSet replenished(FeatureSet features, const Picture& picture, const RenderedView& view,
                       const Pose& T_camera_world, int max_features) {
  const int room = max_features - static_cast<int>(features.size());
  // A few lost features are no reason to look for corners in every frame.
  if (room < max_features / 10) return features;
  std::vector<Eigen::Vector2d> taken;
  for (const auto& feature : features) taken.push_back(feature.pixel);
  const Eigen::Vector3d eye_world = T_camera_world.inverse().translation();
  CornerOptions corner_options;
  corner_options.max_corners = room;
  for (const auto& corner : find_corners(picture.grey, surface_mask(view), taken, corner_options)) {
    const auto in_view = pixel_in_view(view, T_camera_world, corner);
    const auto point = in_view ? world_point(view, *in_view) : std::nullopt;
    if (!point) continue;
    features.push_back({corner, *point, eye_world, looks_as_modelled(view, *in_view, picture.contrast, corner), 0});
  }
  return features;
}

std::vector<PointObservation> observations_of(const FeatureSet& features, double sigma_px) {
  std::vector<PointObservation> observations;
  for (const auto& feature : features) {
    if (feature.trusted) observations.push_back({feature.p_world, feature.pixel, sigma_px});
  }
  return observations;
}

std::vector<PointObservation> observations_of_all(const FeatureSet& features, double sigma_px) {
  std::vector<PointObservation> observations;
  for (const auto& feature : features) observations.push_back({feature.p_world, feature.pixel, sigma_px});
  return observations;
}

}  // namespace meshloop
