#include "common/simulation/camera_path.h"

#include <array>
#include <cmath>
#include <numbers>

namespace meshloop::simulation {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kRests = 5;
// Share of the mean speed that is left while the hand rests.
constexpr double kRestSpeed = 0.06;

// Rounds as a function of time in rounds. The speed is (2/3)(1 - cos x)^2 times the mean, which is flat at the rests;
// this is its integral.
double rounds_at(double time) {
  const double x = kTurn * kRests * time;
  const double stepped = (x - (4.0 / 3.0) * std::sin(x) + std::sin(2 * x) / 6) / (kTurn * kRests);
  return kRestSpeed * time + (1 - kRestSpeed) * stepped;
}

Eigen::Vector3d wobble(double t_s, double phase) {
  return {std::sin(kTurn * 0.43 * t_s + phase) + 0.4 * std::sin(kTurn * 1.07 * t_s + 2 * phase),
          std::sin(kTurn * 0.37 * t_s + 1.3 + phase) + 0.4 * std::sin(kTurn * 0.91 * t_s + phase),
          std::sin(kTurn * 0.51 * t_s + 2.1 + phase) + 0.4 * std::sin(kTurn * 1.13 * t_s + 3 * phase)};
}

// On a circle `distance_m` from `target`, `height_m` above it; angle 0 is in front (-y).
Eigen::Vector3d on_circle(const Eigen::Vector3d& target, double angle, double distance_m, double height_m) {
  const double radius = std::sqrt(distance_m * distance_m - height_m * height_m);
  return target + Eigen::Vector3d(-radius * std::sin(angle), -radius * std::cos(angle), height_m);
}

}  // namespace

Pose StationPath::at(double t_s) const {
  const double phase = half == 0 ? 0.0 : 2.4;
  const double angle = kTurn * rounds_at(t_s / round_s);
  const double sine = std::sin(angle);
  const double distance = (half == 0 ? 1.30 : 1.26) + 0.06 * sine * sine;
  const double height = half == 0 ? 0.60 + 0.08 * std::cos(2 * angle) : 0.66 - 0.05 * std::cos(angle);
  const Eigen::Vector3d centre(0, 0, 0.03);
  const Eigen::Vector3d eye = on_circle(centre, angle, distance, height) + 0.010 * wobble(t_s, phase);
  const Eigen::Vector3d target = centre + 0.015 * wobble(t_s, phase + 1);
  const double roll = 0.012 * std::sin(kTurn * 0.29 * t_s + phase);
  return look_at(eye, target, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
}

Pose DevicePath::at(double t_s) const {
  // It begins where a marker lies whole in the picture, and is nearest on the side where bricks are behind the box.
  constexpr double kStart = 0.9;
  constexpr double kNearest = 4.4;
  const double angle = kStart + kTurn * t_s / round_s;
  const Eigen::Vector3d centre(0.31, 0, 0.06);
  const double distance = nearest_m + (farthest_m - nearest_m) * (1 - std::cos(angle - kNearest)) / 2;
  const double height = 0.20 + 0.28 * distance + 0.02 * std::sin(2 * angle);
  const Eigen::Vector3d eye = on_circle(centre, angle, distance, height);
  return look_at(eye + 0.004 * wobble(t_s, 0.7), centre + 0.006 * wobble(t_s, 1.9), Eigen::Vector3d::UnitZ());
}

}  // namespace meshloop::simulation
