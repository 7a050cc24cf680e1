#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/features/closed_form_pose.h"
#include "common/features/markers.h"

namespace meshloop {
namespace {

// Beyond this a corner contradicts the others: its marker was moved, or is not the one it seems to be.
constexpr double kContradictionPx = 5;
// How far the pose of one marker alone may put another one off.
constexpr double kStartPx = 20;
// Two poses this near are the same minimum.
constexpr double kSameAngle = 0.01;
constexpr double kSameShift = 0.01;
// The better of two poses is clearly better when its corners' squared residuals are lower by this much, in units of
// their variance: e^-10 for normal noise.
constexpr double kClearlyBetter = 20;

const Marker* find_marker(const MarkerMap& map, int id) {
  const auto found = std::find_if(map.markers.begin(), map.markers.end(), [id](const Marker& m) { return m.id == id; });
  return found == map.markers.end() ? nullptr : &*found;
}

struct KnownSighting {
  const Marker* marker;
  const MarkerSighting* sighting;
};

std::vector<KnownSighting> known_of(const std::vector<MarkerSighting>& sightings, const MarkerMap& map) {
  std::vector<KnownSighting> known;
  for (const MarkerSighting& sighting : sightings) {
    const auto finite = [](const Eigen::Vector2d& p) { return p.allFinite(); };
    if (!std::all_of(sighting.pixels.begin(), sighting.pixels.end(), finite) || !(sighting.sigma_px > 0)) continue;
    if (const Marker* marker = find_marker(map, sighting.id)) known.push_back({marker, &sighting});
  }
  return known;
}

// The marker's own frame as poses_from_square has it.
Pose frame_of(const Marker& marker) {
  const auto& c = marker.corners;
  const Eigen::Vector3d x = (c[1] + c[2] - c[0] - c[3]).normalized();
  const Eigen::Vector3d z = x.cross(c[0] + c[1] - c[2] - c[3]).normalized();
  Pose T_world_marker = Pose::Identity();
  T_world_marker.linear().col(0) = x;
  T_world_marker.linear().col(1) = z.cross(x);
  T_world_marker.linear().col(2) = z;
  T_world_marker.translation() = (c[0] + c[1] + c[2] + c[3]) / 4;
  return T_world_marker;
}

std::vector<Pose> poses_from_one(const KnownSighting& known, const Camera& camera) {
  const double side_m = (known.marker->corners[1] - known.marker->corners[0]).norm();
  const Pose T_marker_world = frame_of(*known.marker).inverse();
  std::vector<Pose> poses = poses_from_square(side_m, known.sighting->pixels, camera);
  for (Pose& pose : poses) pose = pose * T_marker_world;
  return poses;
}

std::vector<PointObservation> observations_of(const std::vector<KnownSighting>& known) {
  std::vector<PointObservation> points;
  for (const auto& [marker, sighting] : known) {
    for (std::size_t k = 0; k < 4; ++k) points.push_back({marker->corners[k], sighting->pixels[k], sighting->sigma_px});
  }
  return points;
}

bool same_minimum(const Pose& a, const Pose& b) {
  const Pose difference = a * b.inverse();
  const double depth = std::max(0.1, a.translation().norm());
  return Eigen::AngleAxisd{difference.linear()}.angle() < kSameAngle &&
         (a.inverse().translation() - b.inverse().translation()).norm() < kSameShift * depth;
}

bool better(const RobustPose& a, const RobustPose& b) {
  return a.inliers != b.inliers ? a.inliers > b.inliers : a.rms_px < b.rms_px;
}

// Of the inliers' residuals, each over its standard deviation.
double squares(const RobustPose& pose, const std::vector<KnownSighting>& known, const Camera& camera) {
  double sum = 0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (!pose.inlier[4 * i + k]) continue;
      const Eigen::Vector3d p = pose.T_camera_world * known[i].marker->corners[k];
      const double error = (camera.project(p) - known[i].sighting->pixels[k]).norm() / known[i].sighting->sigma_px;
      sum += error * error;
    }
  }
  return sum;
}

bool clearly_better(const RobustPose& a, const RobustPose& b, const std::vector<KnownSighting>& known,
                    const Camera& camera) {
  if (a.inliers != b.inliers) return a.inliers > b.inliers;
  const double freedom = std::max(1.0, 2.0 * a.inliers - 6);
  const double squares_a = squares(a, known, camera);
  const double variance = std::max(1.0, squares_a / freedom);
  return squares(b, known, camera) - squares_a > kClearlyBetter * variance;
}

double worst_error(const KnownSighting& known, const Camera& camera, const Pose& pose) {
  double worst = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d p = pose * known.marker->corners[k];
    if (p.z() <= 0) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, (camera.project(p) - known.sighting->pixels[k]).norm());
  }
  return worst;
}

// Refined with the markers that lie within `gate_px` of where the start has them; with at least one of them.
std::optional<RobustPose> refine_with(const std::vector<KnownSighting>& known, const Camera& camera, const Pose& start,
                                      double gate_px) {
  std::vector<KnownSighting> agreeing;
  for (const KnownSighting& one : known) {
    if (worst_error(one, camera, start) <= gate_px) agreeing.push_back(one);
  }
  RobustPoseOptions options;
  options.max_error_px = kContradictionPx;
  options.min_inliers = 4;
  auto pose = refine_pose(observations_of(agreeing), camera, start, options);
  if (!pose) return std::nullopt;
  const std::vector<bool> inlier = std::move(pose->inlier);
  pose->inlier.clear();
  std::size_t next = 0;
  for (const KnownSighting& one : known) {
    const bool agrees = worst_error(one, camera, start) <= gate_px;
    for (std::size_t k = 0; k < 4; ++k) pose->inlier.push_back(agrees && inlier[next++]);
  }
  return pose;
}

// All minima that the markers' own poses lead to, best first.
std::vector<RobustPose> minima(const std::vector<KnownSighting>& known, const Camera& camera,
                               const std::optional<Pose>& prior) {
  std::vector<Pose> starts;
  if (prior) starts.push_back(*prior);
  for (const KnownSighting& one : known) {
    for (const Pose& pose : poses_from_one(one, camera)) starts.push_back(pose);
  }
  std::vector<RobustPose> found;
  for (const Pose& start : starts) {
    const auto rough = refine_with(known, camera, start, kStartPx);
    const auto pose = rough ? refine_with(known, camera, rough->T_camera_world, kContradictionPx) : std::nullopt;
    if (!pose) continue;
    const bool new_one = std::none_of(found.begin(), found.end(), [&](const RobustPose& other) {
      return same_minimum(other.T_camera_world, pose->T_camera_world);
    });
    if (new_one) found.push_back(*pose);
  }
  std::sort(found.begin(), found.end(), better);
  return found;
}

}  // namespace

std::optional<RobustPose> pose_from_markers(const std::vector<MarkerSighting>& sightings, const MarkerMap& map,
                                            const Camera& camera, const std::optional<Pose>& prior) {
  const std::vector<KnownSighting> known = known_of(sightings, map);
  if (known.empty()) return std::nullopt;
  std::vector<RobustPose> found = minima(known, camera, prior);
  if (found.empty()) return std::nullopt;
  // What is clearly worse than the best does not fit.
  std::erase_if(
      found, [&, best = found.front()](const RobustPose& pose) { return clearly_better(best, pose, known, camera); });
  if (found.size() == 1) return found.front();
  if (!prior) return std::nullopt;
  const auto angle_to_prior = [&](const RobustPose& pose) {
    return Eigen::AngleAxisd{(pose.T_camera_world * prior->inverse()).linear()}.angle();
  };
  return *std::min_element(found.begin(), found.end(), [&](const RobustPose& a, const RobustPose& b) {
    return angle_to_prior(a) < angle_to_prior(b);
  });
}

}  // namespace meshloop
