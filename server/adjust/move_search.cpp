#include "server/adjust/move_search.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/adjust/move_color.h"
#include "server/adjust/move_fit.h"
#include "server/adjust/move_starts.h"

namespace meshloop::adjust {
namespace {

constexpr std::size_t kCoarsePoints = 150;
constexpr std::size_t kMostPlaces = 3;
constexpr double kLeastCoarse = 0.5;
/// Poses this near to each other lead to one place.
constexpr double kSamePose_m = 0.01;
constexpr double kNear_m = 0.04;
/// Correlations of colours: too low for the same thing, and a difference that tells.
constexpr double kOtherThing = 0.2;
constexpr double kTells = 0.15;
/// Of its confidence a pose loses at most so much when it cannot be told from others.
constexpr double kGuess = 0.4;
/// Poses whose middles are no farther apart, in radii, show one surface.
constexpr double kOnePlace = 0.3;
/// Places that leave no more than so much more unexplained count as equal.
constexpr double kEqual = 0.005;
/// Less is no move.
constexpr double kLeastWay_m = 0.003;

/// A place, and the ways to stand there that look alike.
struct Place {
  MoveFit fit;
  MoveCheck check;
  std::vector<Pose> stands;
};

std::vector<MoveFit> coarse_fits(const MoveScene& scene, const Part& part, const WithoutPart& without) {
  std::vector<MoveFit> fits;
  for (const auto& start : starts_of(scene, part, without)) {
    MoveFit fit = fit_faces(scene, part, without, start, kCoarsePoints);
    if (fit.agreeing < kLeastCoarse) continue;
    const auto same = std::find_if(fits.begin(), fits.end(), [&](const MoveFit& other) {
      return way_m(part, other.T_camera_node, fit.T_camera_node) < kSamePose_m;
    });
    if (same == fits.end()) {
      fits.push_back(fit);
    } else if (fit.agreeing > same->agreeing) {
      *same = fit;
    }
  }
  std::stable_sort(fits.begin(), fits.end(),
                   [](const MoveFit& a, const MoveFit& b) { return a.agreeing > b.agreeing; });
  return fits;
}

/// Up to kMostPlaces that look different, the best first.
std::vector<Place> places_of(const MoveScene& scene, const Part& part, const WithoutPart& without) {
  std::vector<Place> places;
  const auto is_known = [&](const Pose& pose, double near_m) {
    return std::any_of(places.begin(), places.end(), [&](const Place& place) {
      return std::any_of(place.stands.begin(), place.stands.end(),
                         [&](const Pose& stand) { return way_m(part, stand, pose) < near_m; });
    });
  };
  for (const auto& coarse : coarse_fits(scene, part, without)) {
    if (places.size() == kMostPlaces) break;
    if (is_known(coarse.T_camera_node, kNear_m)) continue;
    Place place;
    place.fit = fit_outline(scene, part, without, coarse.T_camera_node);
    if (is_known(place.fit.T_camera_node, kSamePose_m)) continue;
    place.check = check_move(scene, part, without, place.fit.T_camera_node);
    place.stands = look_alikes(scene, part, place.fit.T_camera_node);
    places.push_back(std::move(place));
  }
  return places;
}

/// One of the ways to stand at a place.
struct Stand {
  Pose T_camera_node;
  double way_m = 0;
  std::optional<double> color;
};

std::vector<Stand> stands_of(const MoveScene& scene, const Part& part, const PartColors& colors, const Place& place) {
  std::vector<Stand> stands;
  const Pose old = scene.T_camera_node(part.node_position);
  for (const auto& pose : place.stands) {
    stands.push_back({pose, way_m(part, old, pose), color_agreement(scene, part, colors, pose)});
  }
  return stands;
}

/// Which of them it is: by colour where that tells, else the one with the shortest way.
struct Choice {
  Stand stand;
  /// From 1 down to 1 - kGuess, the longer the way is in comparison with the next.
  double confidence = 1;
};

Choice choose(std::vector<Stand> stands) {
  if (stands.size() == 1) return {stands.front(), 1};
  const auto color = [](const Stand& stand) { return stand.color.value_or(-2); };
  std::stable_sort(stands.begin(), stands.end(), [&](const Stand& a, const Stand& b) { return color(a) > color(b); });
  if (color(stands[0]) > color(stands[1]) + kTells && color(stands[0]) > kOtherThing) return {stands.front(), 1};
  std::stable_sort(stands.begin(), stands.end(), [](const Stand& a, const Stand& b) { return a.way_m < b.way_m; });
  return {stands.front(), 1 - kGuess * stands[0].way_m / stands[1].way_m};
}

bool is_other_thing(const Choice& choice) {
  return choice.stand.color.has_value() && *choice.stand.color < kOtherThing;
}

std::optional<NewPlace> stand_at(const MoveScene& scene, const Part& part, const WithoutPart& without,
                                 const PartColors& colors, const Place& place) {
  const Choice choice = choose(stands_of(scene, part, colors, place));
  if (is_other_thing(choice)) return std::nullopt;
  const MoveFit fit = fit_outline(scene, part, without, choice.stand.T_camera_node);
  if (fit.slides) return std::nullopt;
  if (way_m(part, scene.T_camera_node(part.node_position), fit.T_camera_node) < kLeastWay_m) return std::nullopt;
  NewPlace found{fit.T_camera_node, check_move(scene, part, without, fit.T_camera_node), 0};
  if (found.check.refusal()) return std::nullopt;
  const double held = fit.free_directions == 0 ? 1 : 1 - kGuess;
  found.confidence = found.check.agreeing * found.check.explained * std::min(held, choice.confidence);
  return found;
}

/// Only those that explain the measurements as well as the best one does.
void keep_the_best(std::vector<Place>& places) {
  double least = 1;
  for (const auto& place : places) least = std::min(least, place.check.unexplained());
  std::erase_if(places, [&](const Place& place) { return place.check.unexplained() > least + kEqual; });
}

// Several poses explain what is measured. At one place it is the nearest if colour does not tell; at several it is
// none.
std::optional<NewPlace> tell_apart(const MoveScene& scene, const Part& part, const PartColors& colors,
                                   std::vector<NewPlace> found) {
  std::vector<Stand> stands;
  const Pose old = scene.T_camera_node(part.node_position);
  for (const auto& place : found) {
    const Pose& pose = place.T_camera_node;
    stands.push_back({pose, way_m(part, old, pose), color_agreement(scene, part, colors, pose)});
  }
  const Choice choice = choose(stands);
  const auto chosen = std::find_if(found.begin(), found.end(), [&](const NewPlace& place) {
    return place.T_camera_node.matrix() == choice.stand.T_camera_node.matrix();
  });
  const Eigen::Vector3d center = chosen->T_camera_node * part.center;
  const bool is_one_place = std::all_of(found.begin(), found.end(), [&](const NewPlace& place) {
    return (place.T_camera_node * part.center - center).norm() < kOnePlace * part.radius_m;
  });
  if (choice.confidence < 1 && !is_one_place) return std::nullopt;
  chosen->confidence *= choice.confidence;
  return std::move(*chosen);
}

}  // namespace

std::optional<NewPlace> find_new_place(const MoveScene& scene, const Part& part, const WithoutPart& without,
                                       const ColorLookup& seen) {
  std::vector<Place> places = places_of(scene, part, without);
  std::erase_if(places, [](const Place& place) { return place.fit.slides || place.check.refusal().has_value(); });
  keep_the_best(places);
  if (places.empty()) return std::nullopt;
  const PartColors colors = colors_of(part, seen);
  std::vector<NewPlace> found;
  for (const auto& place : places) {
    auto stand = stand_at(scene, part, without, colors, place);
    if (!stand) continue;
    const auto same = std::find_if(found.begin(), found.end(), [&](const NewPlace& other) {
      return way_m(part, other.T_camera_node, stand->T_camera_node) < kSamePose_m;
    });
    if (same == found.end()) {
      found.push_back(std::move(*stand));
    } else if (stand->check.unexplained() < same->check.unexplained()) {
      *same = std::move(*stand);
    }
  }
  if (found.empty()) return std::nullopt;
  if (found.size() == 1) return std::move(found.front());
  return tell_apart(scene, part, colors, std::move(found));
}

}  // namespace meshloop::adjust
