#include "server/adjust/gates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/base/median.h"

namespace meshloop {
namespace {

constexpr double kExposure_s = 1.0 / 60;
constexpr double kMostSmear_sigmas = 3;
constexpr double kMostBeside_px = 4;
constexpr double kMostDisagreement_sigmas = 5;
constexpr double kLeastShareNearer = 0.85;
constexpr double kLeastAgreeing = 0.5;

double degrees(double radians) {
  return radians * 180 / std::numbers::pi;
}

/// Of every eighth pixel each way; 0 when nothing is measured.
double median_depth_m(const DepthImage& depth) {
  std::vector<float> depths;
  for (int y = 0; y < depth.height(); y += 8) {
    for (int x = 0; x < depth.width(); x += 8) {
      if (depth(x, y) > 0 && std::isfinite(depth(x, y))) depths.push_back(depth(x, y));
    }
  }
  if (depths.empty()) return 0;
  return static_cast<double>(median(std::move(depths)));
}

/// How fast what the camera sees at this depth moves in its frame, in the middle of the picture, m/s.
double surface_speed(const Twist& per_s, double z_m) {
  return (per_s.head<3>() + per_s.tail<3>().cross(Eigen::Vector3d{0, 0, z_m})).norm();
}

constexpr const char* kWhatToDo = "check the given pose or trajectory, the markers' file, and the calibration";

}  // namespace

std::optional<std::string> reason_against_motion(const CameraMotion& motion, const DepthImage& depth, const Rig& rig) {
  if (!motion.per_s) return std::nullopt;
  const double z_m = median_depth_m(depth);
  if (z_m == 0) return std::nullopt;
  const double speed = surface_speed(*motion.per_s, z_m);
  const double smear_m = speed * kExposure_s;
  // No measurement is finer than a pixel is wide.
  const double sigma_m = std::hypot(rig.sensor.sigma_z_m(z_m, 0), z_m / rig.depth.fx);
  if (!(smear_m <= kMostSmear_sigmas * sigma_m)) {
    return fmt::format(
        "the camera moved while it measured: by {:.1f} mm, {:.1f} sigma of a measurement; hold it still for the "
        "snapshot",
        1000 * smear_m, smear_m / sigma_m);
  }
  const double beside_px = speed * std::abs(motion.between_exposures_s) * rig.color.fx / z_m;
  if (!(beside_px <= kMostBeside_px)) {
    return fmt::format(
        "the camera moved between the exposures of depth and colour: colours would lie {:.1f} pixels beside; hold it "
        "still for the snapshot",
        beside_px);
  }
  return std::nullopt;
}

std::optional<std::string> reason_against_registration(const Registration& registration) {
  if (registration.disagreement_sigmas <= kMostDisagreement_sigmas) return std::nullopt;
  if (registration.share_agreeing < kLeastAgreeing || registration.share_nearer < kLeastShareNearer) {
    return std::nullopt;
  }
  const Twist& found = registration.found;
  return fmt::format(
      "the pose lies {:.1f} mm and {:.2f} degrees beside what of the model has not changed, {:.0f} sigma: {}",
      1000 * found.head<3>().norm(), degrees(found.tail<3>().norm()), registration.disagreement_sigmas, kWhatToDo);
}

std::optional<std::string> reason_against_unconfirmed(const Registration& registration, const Model& model) {
  constexpr double kLeastConfirming = 0.2;
  constexpr int kLeastPoints = 100;
  if (model.triangle_count() == 0) return std::nullopt;
  if (registration.share_agreeing >= kLeastConfirming && registration.points >= kLeastPoints) return std::nullopt;
  return "nothing confirms the pose that was given: hardly anything that is measured is where the model has it; let "
         "the "
         "camera see what the model has, or markers";
}

std::optional<std::string> reason_against_rings(const EdgeRings& rings) {
  if (!rings.is_misregistered()) return std::nullopt;
  // Without figures: the motion that explains most shifts need not be how far the pose is off.
  return fmt::format("outlines all over the picture are ringed with closer and farther pixels, as by a wrong pose: {}",
                     kWhatToDo);
}

}  // namespace meshloop
