#include "server/adjust/registration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/base/median.h"
#include "server/adjust/expected_planes.h"

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
/// Errors of neighbouring points are alike: so many count as one.
constexpr double kCorrelated = 10;
constexpr double kLargest_sigmas = 5;
constexpr double kLeastShare = 0.2;
/// The points must come nearer by this share.
constexpr double kBetter = 0.01;
/// A point that the correction shifts by less says nothing of it.
constexpr double kShifted_sigmas = 2;
/// What no covariance knows: how exact the model and the calibration are, as one sigma of the pose in each direction.
constexpr double kUnknown_m = 0.002;
constexpr double kUnknown_rad = 0.002;

using adjust::ExpectedPlanes;

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
    const auto* plane = planes.at(moved);
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

/// Rotations count by the way of a point at `depth_m`.
Twist scale_at(double depth_m) {
  Twist scale;
  scale << 1, 1, 1, 1 / depth_m, 1 / depth_m, 1 / depth_m;
  return scale;
}

/// What the pose itself says of `move`, and how the points pull it; these only in directions that they hold.
Step solve(const Fit& fit, const Pose& move, const PoseCovariance& prior, double depth_m) {
  Step step;
  if (!(fit.weight > 0)) return step;
  const Twist scale = scale_at(depth_m);
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

/// How far the place that the points alone ask for lies from the pose, in sigma of both together, in the directions
/// that the points hold. `correction`: where both are in equilibrium; `prior`: the inverse of the pose's covariance.
double disagreement_sigmas(const Fit& fit, const Twist& correction, const PoseCovariance& covariance,
                           const PoseCovariance& prior, double depth_m) {
  if (!(fit.weight > 0)) return 0;
  const Twist scale = scale_at(depth_m);
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> solver{scale.asDiagonal() * fit.information * scale.asDiagonal() /
                                                             fit.weight};
  const double weight = fit.weight / kCorrelated;
  const Twist pull = scale.asDiagonal() * (prior * correction);
  const PoseCovariance of_pose = scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
  // In the basis of the directions; those that are not held have no say.
  PoseCovariance both = solver.eigenvectors().transpose() * of_pose * solver.eigenvectors();
  Twist away = solver.eigenvectors().transpose() * correction.cwiseQuotient(scale);
  for (int i = 0; i < 6; ++i) {
    if (solver.eigenvalues()[i] <= kHeld) {
      both.row(i).setZero();
      both.col(i).setZero();
      both(i, i) = 1;
      away[i] = 0;
      continue;
    }
    const double variance = 1 / (weight * solver.eigenvalues()[i]);
    both(i, i) += variance;
    away[i] += variance * solver.eigenvectors().col(i).dot(pull);
  }
  return std::sqrt(away.dot(both.ldlt().solve(away)));
}

/// Of the points that the move shifts visibly across the model's planes, those that come nearer to them.
double share_nearer(ExpectedPlanes& planes, const std::vector<Measured>& points, const Pose& move) {
  int shifted = 0;
  int nearer = 0;
  for (const auto& [p, sigma_m] : points) {
    const Eigen::Vector3d moved = move * p;
    const auto* before = planes.at(p);
    const auto* after = planes.at(moved);
    if (before == nullptr || after == nullptr) continue;
    const double before_m = before->signedDistance(p);
    const double after_m = after->signedDistance(moved);
    if (std::abs(after_m - before_m) < kShifted_sigmas * sigma_m) continue;
    ++shifted;
    nearer += std::abs(after_m) < std::abs(before_m) ? 1 : 0;
  }
  return shifted > 0 ? static_cast<double>(nearer) / shifted : 0;
}

double root_mean_square(const Fit& fit) {
  return fit.weight > 0 ? std::sqrt(fit.weighted_squares / fit.weight) : 0;
}

double median_depth(const std::vector<Measured>& points) {
  std::vector<double> depths;
  for (const auto& measured : points) depths.push_back(measured.point.z());
  return median(std::move(depths));
}

std::optional<std::string> reason_to_refuse(const Fit& before, const Fit& after, const Twist& correction,
                                            const PoseCovariance& prior) {
  if (after.looked_at == 0) return "nothing of the model is in view";
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

/// Where points and pose together are in equilibrium.
struct Settled {
  Pose move = Pose::Identity();
  int held = 0;
};
Settled settle(ExpectedPlanes& planes, const std::vector<Measured>& points, const PoseCovariance& prior,
               double depth_m) {
  Settled settled;
  for (const double cut_m : kCuts_m) {
    for (int round = 0; round < kRounds; ++round) {
      const Step step = solve(fit(planes, points, settled.move, cut_m), settled.move, prior, depth_m);
      settled.move = exp(step.twist) * settled.move;
      settled.held = step.held;
      if (step.twist.norm() < kSettled) break;
    }
  }
  return settled;
}

/// The model's own answer, whatever the pose says of its certainty: what no covariance knows is added to it.
void look_for_disagreement(ExpectedPlanes& planes, const std::vector<Measured>& points,
                           const PoseCovariance& covariance, double depth_m, Registration& result) {
  PoseCovariance wide = covariance;
  wide.diagonal().head<3>().array() += kUnknown_m * kUnknown_m;
  wide.diagonal().tail<3>().array() += kUnknown_rad * kUnknown_rad;
  const PoseCovariance prior = wide.inverse();
  const Pose move = settle(planes, points, prior, depth_m).move;
  const Fit there = fit(planes, points, move, 0);
  result.found = log(move);
  result.disagreement_sigmas = disagreement_sigmas(there, result.found, wide, prior, depth_m);
  result.share_agreeing = there.looked_at > 0 ? static_cast<double>(there.agreeing) / there.looked_at : 0;
  result.share_nearer = share_nearer(planes, points, move);
}

}  // namespace

Registration refine_pose(const Snapshot& snapshot) {
  Registration result;
  result.T_camera_world = snapshot.depth_pose.T_camera_world;
  ExpectedPlanes planes{*snapshot.comparison, snapshot.rig->depth, snapshot.rig->sensor};
  const auto points = measured_points(snapshot);
  if (points.empty()) {
    result.refused = "nothing is measured";
    return result;
  }
  const double depth_m = median_depth(points);
  look_for_disagreement(planes, points, snapshot.depth_pose.covariance, depth_m, result);
  const Eigen::LLT<PoseCovariance> covariance{snapshot.depth_pose.covariance};
  if (covariance.info() != Eigen::Success) {
    result.refused = "the pose counts as exact";
    return result;
  }
  const PoseCovariance prior = covariance.solve(PoseCovariance::Identity());
  const auto [move, held] = settle(planes, points, prior, depth_m);
  result.held_directions = held;
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
