#include "device/track/alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "device/track/local_contrast.h"

namespace meshloop {
namespace {

constexpr double kPointAgrees_px = 2;
constexpr double kEdgeAgrees_px = 1;
/// The absolute matches hold the drift down, the followed features the jitter.
constexpr double kMatchSigma_px = 0.7;
constexpr double kFollowedSigma_px = 1.2;
/// Larger than an edge's own error: a dozen samples of one edge share what is wrong with it.
constexpr double kEdgeSigma_px = 1.2;
constexpr int kEdgeSpacing_px = 6;
constexpr double kBlur_px = 1.0;
constexpr double kRepeatAbove_px = 3;
/// Of the second solution from the same observations: right edges lie within a third of a pixel, and a long wrong one
/// (a shadow's border beside a real edge) must not bear on the pose.
constexpr double kLastGate_px = 1.0;

/// One drawing of the model, and how far it looks.
struct Round {
  AbsoluteSearch points;
  EdgeSearch edges;
  /// Observations farther off than this do not count.
  double gate_px = 3;
};

Round close_round() {
  return {AbsoluteSearch{}, EdgeSearch{}, 4};
}

std::array<Round, 4> wide_rounds() {
  return {{{wide_search(), {16, 5}, 16}, {wide_search(), {10, 5}, 8}, close_round(), close_round()}};
}

struct Observations {
  std::vector<PointObservation> matches;
  std::vector<EdgeObservation> edges;
};

Observations observe(const RenderedView& view, const Picture& picture, const Round& round) {
  Observations found;
  found.matches = observations_of(match_view(view, picture.contrast, round.points), kMatchSigma_px);
  found.edges = match_edges(find_model_edges(view, kEdgeSpacing_px), picture.smooth, round.edges, kEdgeSigma_px);
  return found;
}

void count_votes(Alignment& now, const Observations& found, const Camera& camera) {
  const auto agrees = [&](const PointObservation& point) {
    const Eigen::Vector3d p_camera = now.T_camera_world * point.p_world;
    return p_camera.z() > 0 && (camera.project(p_camera) - point.pixel).norm() <= kPointAgrees_px;
  };
  const auto edge_agrees = [&](const EdgeObservation& edge) {
    return std::abs(edge_error_px(edge, camera, now.T_camera_world)) <= kEdgeAgrees_px;
  };
  now.matches = {static_cast<int>(found.matches.size()),
                 static_cast<int>(std::count_if(found.matches.begin(), found.matches.end(), agrees))};
  now.edges = {static_cast<int>(found.edges.size()),
               static_cast<int>(std::count_if(found.edges.begin(), found.edges.end(), edge_agrees))};
  now.followed = {count_trusted(now.features),
                  count_agreeing(now.features, camera, now.T_camera_world, kPointAgrees_px)};
}

/// With a wide gate, and then with a narrow one when that still fixes the pose.
std::optional<JointPose> solve_twice(const std::vector<PointObservation>& points,
                                     const std::vector<EdgeObservation>& edges, const Camera& camera, const Pose& start,
                                     double gate_px) {
  const auto first = solve_pose(points, edges, camera, start, {gate_px});
  if (!first) return std::nullopt;
  const auto second = solve_pose(points, edges, camera, first->T_camera_world, {kLastGate_px});
  const bool kept_most = second && 3 * (second->points + second->edges) > first->points + first->edges;
  return kept_most ? second : first;
}

/// Draws, observes, solves. How far the pose moved the picture, in pixels; nothing when it could not be solved.
std::optional<double> correct(Alignment& now, SceneRenderer& renderer, const Model& model, const Camera& camera,
                              const Picture& picture, const FeatureSet& features, const Round& round) {
  now.view = render_view(renderer, model, camera, now.T_camera_world);
  now.features = on_surface(features, now.view);
  const Observations found = observe(now.view, picture, round);
  auto points = found.matches;
  const auto followed = observations_of(now.features, kFollowedSigma_px);
  points.insert(points.end(), followed.begin(), followed.end());
  const auto pose = solve_twice(points, found.edges, camera, now.T_camera_world, round.gate_px);
  if (!pose) return std::nullopt;
  double moved_px = 0;
  for (const auto& edge : found.edges) {
    const Eigen::Vector3d before = now.T_camera_world * edge.p_world;
    const Eigen::Vector3d after = pose->T_camera_world * edge.p_world;
    if (after.z() > 0) moved_px = std::max(moved_px, (camera.project(after) - camera.project(before)).norm());
  }
  now.T_camera_world = pose->T_camera_world;
  now.covariance = pose->covariance;
  count_votes(now, found, camera);
  return moved_px;
}

}  // namespace

Picture::Picture(const ColorImage& color)
    : grey{to_grey(color)}, contrast{local_contrast(grey, {}, {})}, smooth{grey.width(), grey.height()} {
  const cv::Mat sharp{grey.height(), grey.width(), CV_8UC1, grey.data()};
  cv::Mat blurred{smooth.height(), smooth.width(), CV_8UC1, smooth.data()};
  cv::GaussianBlur(sharp, blurred, {5, 5}, kBlur_px);
}

int Alignment::inliers() const {
  return matches.agreeing + followed.agreeing + edges.agreeing / 4;
}

double Alignment::agreeing_share() const {
  const double found = matches.found + followed.found + edges.found / 4.0;
  return found > 0 ? (matches.agreeing + followed.agreeing + edges.agreeing / 4.0) / found : 0;
}

std::optional<Alignment> align_closely(SceneRenderer& renderer, const Model& model, const Camera& camera,
                                       const Picture& picture, const Pose& start, const FeatureSet& features) {
  Alignment now;
  now.T_camera_world = start;
  auto moved_px = correct(now, renderer, model, camera, picture, features, close_round());
  if (moved_px && *moved_px > kRepeatAbove_px) {
    moved_px = correct(now, renderer, model, camera, picture, features, close_round());
  }
  if (!moved_px) return std::nullopt;
  return now;
}

std::optional<Alignment> align_widely(SceneRenderer& renderer, const Model& model, const Camera& camera,
                                      const Picture& picture, const Pose& start) {
  Alignment now;
  now.T_camera_world = start;
  for (const auto& round : wide_rounds()) {
    if (!correct(now, renderer, model, camera, picture, {}, round)) return std::nullopt;
  }
  return now;
}

}  // namespace meshloop
