#include "server/adjust/registration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace meshloop {
namespace {

/// 640x480 pixels give 19,000 points.
constexpr int kEvery_px = 4;
/// Tukey's weight is zero from here on; in sigma, and at first in metres too.
constexpr double kCut_sigmas = 5;
constexpr std::array<double, 4> kCuts_m{0.08, 0.04, 0.02, 0};
constexpr int kRounds = 8;
/// Metres and radians: the pose moves no more.
constexpr double kSettled = 2e-5;
/// A direction is held when the mean square of the planes' normals along it is more than this.
constexpr double kHeld = 0.0005;
/// A bend of the model between neighbouring pixels that is less than this is none.
constexpr double kBend_sigmas = 0.2;
/// Errors of neighbouring points are alike: so many count as one.
constexpr double kCorrelated = 10;
constexpr double kLargest_sigmas = 5;
constexpr double kLeastShare = 0.2;
/// The points must come nearer by this share.
constexpr double kBetter = 0.01;

using Plane = Eigen::Hyperplane<double, 3>;

/// The model as the snapshot's pose expects it, in that camera's frame: a plane for each pixel, made when it is asked
/// for.
class ExpectedPlanes {
 public:
  explicit ExpectedPlanes(const Snapshot& snapshot)
      : comparison_{*snapshot.comparison},
        camera_{snapshot.rig->depth},
        sensor_{snapshot.rig->sensor},
        planes_(snapshot.comparison->expected.size()),
        states_(planes_.size(), State::unknown) {}

  /// At the pixel that shows the point; null where the picture shows no plane.
  [[nodiscard]] const Plane* at(const Eigen::Vector3d& p) {
    if (!(p.z() > 0.01)) return nullptr;
    const Eigen::Vector2d pixel = camera_.project(p);
    if (!camera_.contains(pixel, 1)) return nullptr;
    const int x = static_cast<int>(pixel.x() + 0.5);
    const int y = static_cast<int>(pixel.y() + 0.5);
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(x);
    if (states_[i] == State::unknown) states_[i] = make(x, y, planes_[i]) ? State::plane : State::none;
    return states_[i] == State::plane ? &planes_[i] : nullptr;
  }

 private:
  enum class State : std::uint8_t { unknown, none, plane };

  [[nodiscard]] bool make(int x, int y, Plane& plane) const {
    if (!is_straight(x, y, 1, 0) || !is_straight(x, y, 0, 1)) return false;
    const Eigen::Vector3d across = point(x + 1, y) - point(x - 1, y);
    const Eigen::Vector3d down = point(x, y + 1) - point(x, y - 1);
    plane = Plane{across.cross(down).normalized(), point(x, y)};
    return true;
  }
  [[nodiscard]] Eigen::Vector3d point(int x, int y) const {
    return camera_.back_project(x, y, static_cast<double>(comparison_.expected(x, y)));
  }
  /// No bend that the sensor could tell: on a plane one divided by the depth is linear in the picture.
  [[nodiscard]] bool is_straight(int x, int y, int dx, int dy) const {
    const auto node = comparison_.node_index(x, y);
    if (node == 0 || comparison_.node_index(x - dx, y - dy) != node || comparison_.node_index(x + dx, y + dy) != node) {
      return false;
    }
    const double z = comparison_.expected(x, y);
    const double straight_z = 2 / (1 / static_cast<double>(comparison_.expected(x - dx, y - dy)) +
                                   1 / static_cast<double>(comparison_.expected(x + dx, y + dy)));
    return std::abs(z - straight_z) < kBend_sigmas * sensor_.sigma_z_m(z, 0);
  }

  const Comparison& comparison_;
  const Camera& camera_;
  const SensorModel& sensor_;
  std::vector<Plane> planes_;
  std::vector<State> states_;
};

struct Measured {
  Eigen::Vector3d point;
  double sigma_m;
};

std::vector<Measured> measured_points(const Snapshot& snapshot) {
  std::vector<Measured> points;
  const DepthImage& depth = snapshot.frame->depth;
  for (int y = kEvery_px / 2; y < depth.height(); y += kEvery_px) {
    for (int x = kEvery_px / 2; x < depth.width(); x += kEvery_px) {
      const auto z = static_cast<double>(depth(x, y));
      if (!(z > 0) || !std::isfinite(z)) continue;
      points.push_back({snapshot.rig->depth.back_project(x, y, z), snapshot.rig->sensor.sigma_z_m(z, 0)});
    }
  }
  return points;
}

/// How the points lie to the planes when they are moved. Twists act on the left: first translation, then rotation.
struct Fit {
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> pull = Eigen::Matrix<double, 6, 1>::Zero();
  double weight = 0;
  double weighted_squares = 0;
  double cost = 0;
  int agreeing = 0;
  int looked_at = 0;
};

Fit fit(ExpectedPlanes& planes, const std::vector<Measured>& points, const Pose& move, double cut_m) {
  Fit result;
  for (const auto& [p, sigma_m] : points) {
    const Eigen::Vector3d moved = move * p;
    const Plane* plane = planes.at(moved);
    if (plane == nullptr) continue;
    ++result.looked_at;
    const double cut = std::max(kCut_sigmas * sigma_m, cut_m);
    const double distance = plane->signedDistance(moved);
    const double share = std::min(1.0, distance * distance / (cut * cut));
    result.cost += 1 - (1 - share) * (1 - share) * (1 - share);
    if (share >= 1) continue;
    const double weight = (1 - share) * (1 - share) / (sigma_m * sigma_m);
    Twist along;
    along << plane->normal(), moved.cross(plane->normal());
    result.information += weight * along * along.transpose();
    result.pull -= weight * distance * along;
    result.weight += weight;
    result.weighted_squares += weight * distance * distance;
    ++result.agreeing;
  }
  return result;
}

struct Step {
  Twist twist = Twist::Zero();
  int held = 0;
};

/// What the pose itself says of `move`, and how the points pull it; these only in directions that they hold. Rotations
/// count by the way of a point at `depth_m`.
Step solve(const Fit& fit, const Pose& move, const PoseCovariance& prior, double depth_m) {
  Step step;
  if (!(fit.weight > 0)) return step;
  Twist scale;
  scale << 1, 1, 1, 1 / depth_m, 1 / depth_m, 1 / depth_m;
  const Eigen::Matrix<double, 6, 6> scaled = scale.asDiagonal() * fit.information * scale.asDiagonal() / fit.weight;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver{scaled};
  Eigen::Matrix<double, 6, 6> information = prior;
  Twist pull = -prior * log(move);
  for (int i = 0; i < 6; ++i) {
    if (solver.eigenvalues()[i] <= kHeld) continue;
    // The part of the points' information that lies along this direction.
    const Twist direction = solver.eigenvectors().col(i);
    const Twist along = direction.cwiseQuotient(scale);
    const double weight = fit.weight / kCorrelated;
    information += weight * solver.eigenvalues()[i] * along * along.transpose();
    pull += along * (direction.dot(scale.asDiagonal() * fit.pull) / kCorrelated);
    ++step.held;
  }
  step.twist = information.ldlt().solve(pull);
  return step;
}

double root_mean_square(const Fit& fit) {
  return fit.weight > 0 ? std::sqrt(fit.weighted_squares / fit.weight) : 0;
}

double median_depth(const std::vector<Measured>& points) {
  std::vector<double> depths;
  for (const auto& measured : points) depths.push_back(measured.point.z());
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

std::optional<std::string> reason_to_refuse(const Fit& before, const Fit& after, const Twist& correction,
                                            const PoseCovariance& prior) {
  if (after.agreeing < kLeastShare * after.looked_at) return "too little of the model agrees with what is measured";
  if (after.cost * before.looked_at > (1 - kBetter) * before.cost * after.looked_at)
    return "it does not bring the points nearer to the model";
  const double sigmas = std::sqrt(correction.dot(prior * correction));
  if (!(sigmas <= kLargest_sigmas)) {
    return fmt::format("the correction of {:.1f} mm and {:.2f} degrees is {:.0f} sigma of the pose",
                       1000 * correction.head<3>().norm(), correction.tail<3>().norm() * 180 / std::numbers::pi,
                       sigmas);
  }
  return std::nullopt;
}

}  // namespace

Registration refine_pose(const Snapshot& snapshot) {
  Registration result;
  result.T_camera_world = snapshot.depth_pose.T_camera_world;
  ExpectedPlanes planes{snapshot};
  const auto points = measured_points(snapshot);
  if (points.empty()) {
    result.refused = "nothing is measured";
    return result;
  }
  const Eigen::LLT<PoseCovariance> covariance{snapshot.depth_pose.covariance};
  if (covariance.info() != Eigen::Success) {
    result.refused = "the pose counts as exact";
    return result;
  }
  const PoseCovariance prior = covariance.solve(PoseCovariance::Identity());
  const double depth_m = median_depth(points);
  Pose move = Pose::Identity();
  for (const double cut_m : kCuts_m) {
    for (int round = 0; round < kRounds; ++round) {
      const Step step = solve(fit(planes, points, move, cut_m), move, prior, depth_m);
      move = exp(step.twist) * move;
      result.held_directions = step.held;
      if (step.twist.norm() < kSettled) break;
    }
  }
  const Fit before = fit(planes, points, Pose::Identity(), 0);
  const Fit after = fit(planes, points, move, 0);
  result.before_m = root_mean_square(before);
  result.after_m = root_mean_square(after);
  result.points = after.agreeing;
  result.looked_at = after.looked_at;
  result.refused = reason_to_refuse(before, after, log(move), prior);
  if (!result.refused) result.T_camera_world = move.inverse() * snapshot.depth_pose.T_camera_world;
  return result;
}

}  // namespace meshloop
