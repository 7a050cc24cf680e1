#include "device/track/alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

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

bool agrees(const PointObservation& point, const Camera& camera, const Pose& T_camera_world) {
  const Eigen::Vector3d p_camera = T_camera_world * point.p_world;
  return p_camera.z() > 0 && (camera.project(p_camera) - point.pixel).norm() <= kPointAgrees_px;
}

bool agrees(const EdgeObservation& edge, const Camera& camera, const Pose& T_camera_world) {
  return std::abs(edge_error_px(edge, camera, T_camera_world)) <= kEdgeAgrees_px;
}

template <class Observation>
std::vector<Observation> without_stale(const std::vector<Observation>& observations, const StalePlaces& stale) {
  std::vector<Observation> kept;
  std::copy_if(observations.begin(), observations.end(), std::back_inserter(kept),
               [&](const auto& each) { return !stale.contains(each.p_world); });
  return kept;
}

template <class Observation>
Votes votes_of(const std::vector<Observation>& observations, const Camera& camera, const Pose& T_camera_world) {
  const auto agreeing = std::count_if(observations.begin(), observations.end(),
                                      [&](const auto& each) { return agrees(each, camera, T_camera_world); });
  return {static_cast<int>(observations.size()), static_cast<int>(agreeing)};
}

std::vector<Verdict> verdicts_of(const Observations& found, const Camera& camera, const Pose& T_camera_world) {
  std::vector<Verdict> verdicts;
  const auto add = [&](const auto& each) { verdicts.push_back({each.p_world, agrees(each, camera, T_camera_world)}); };
  std::for_each(found.matches.begin(), found.matches.end(), add);
  std::for_each(found.edges.begin(), found.edges.end(), add);
  return verdicts;
}

/// With a wide gate, and then with a narrow one when that still fixes the pose.
std::optional<JointPose> solve_twice(const std::vector<PointObservation>& points,
                                     const std::vector<EdgeObservation>& edges, const Camera& camera, const Pose& start,
                                     double gate_px) {
  const auto first = solve_pose(points, edges, camera, start, {gate_px});
  if (!first) return std::nullopt;
  const auto second = solve_pose(points, edges, camera, first->T_camera_world, {kLastGate_px});
  const bool kept_enough = second && 3 * (second->points + second->edges) > first->points + first->edges;
  return kept_enough ? second : first;
}

/// The farthest that a second pose moves an observation in the picture, in pixels.
template <class Observation>
double largest_move_px(const std::vector<Observation>& observations, const Camera& camera, const Pose& from,
                       const Pose& to) {
  double moved_px = 0;
  for (const auto& each : observations) {
    const Eigen::Vector3d before = from * each.p_world;
    const Eigen::Vector3d after = to * each.p_world;
    if (after.z() > 0) moved_px = std::max(moved_px, (camera.project(after) - camera.project(before)).norm());
  }
  return moved_px;
}

/// Draws, observes, solves. How far the pose moved the picture, in pixels; nothing when it could not be solved.
std::optional<double> correct(Alignment& now, const Reference& reference, const Picture& picture,
                              const FeatureSet& features, const Round& round) {
  const Camera& camera = reference.camera;
  now.view = render_view(reference.renderer, reference.model, camera, now.T_camera_world);
  now.features = on_surface(features, now.view);
  const Observations found = observe(now.view, picture, round);
  const auto matches = without_stale(found.matches, reference.stale);
  const auto edges = without_stale(found.edges, reference.stale);
  const auto followed = without_stale(observations_of(now.features, kFollowedSigma_px), reference.stale);
  auto points = matches;
  points.insert(points.end(), followed.begin(), followed.end());
  const auto pose = solve_twice(points, edges, camera, now.T_camera_world, round.gate_px);
  if (!pose) return std::nullopt;
  const Pose before = std::exchange(now.T_camera_world, pose->T_camera_world);
  now.covariance = pose->covariance;
  now.matches = votes_of(matches, camera, now.T_camera_world);
  now.edges = votes_of(edges, camera, now.T_camera_world);
  now.followed = votes_of(followed, camera, now.T_camera_world);
  now.verdicts = verdicts_of(found, camera, now.T_camera_world);
  return std::max(largest_move_px(edges, camera, before, now.T_camera_world),
                  largest_move_px(points, camera, before, now.T_camera_world));
}

}  // namespace

int Alignment::inliers() const {
  return inliers_on_model() + followed.agreeing;
}

int Alignment::inliers_on_model() const {
  return matches.agreeing + edges.agreeing / 4;
}

double Alignment::agreeing_share() const {
  const double found = matches.found + followed.found + edges.found / 4.0;
  return found > 0 ? (matches.agreeing + followed.agreeing + edges.agreeing / 4.0) / found : 0;
}

std::optional<Alignment> align_closely(const Reference& reference, const Picture& picture, const Pose& start,
                                       const FeatureSet& features) {
  Alignment now;
  now.T_camera_world = start;
  auto moved_px = correct(now, reference, picture, features, close_round());
  if (moved_px && *moved_px > kRepeatAbove_px) moved_px = correct(now, reference, picture, features, close_round());
  if (!moved_px) return std::nullopt;
  return now;
}

std::optional<Alignment> align_widely(const Reference& reference, const Picture& picture, const Pose& start) {
  Alignment now;
  now.T_camera_world = start;
  for (const auto& round : wide_rounds()) {
    if (!correct(now, reference, picture, {}, round)) return std::nullopt;
  }
  return now;
}

}  // namespace meshloop
