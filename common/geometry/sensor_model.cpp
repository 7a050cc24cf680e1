#include "common/geometry/sensor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace meshloop {
namespace {

constexpr double kGrazing = std::numbers::pi / 3;       // Nguyen's second term counts above 60 degrees
constexpr double kLimit = 80 * std::numbers::pi / 180;  // beyond, the Kinect measures nothing

double grazing_ratio(double theta) {
  const double t = std::clamp(theta, 0.0, kLimit);
  return t / (std::numbers::pi / 2 - t);
}

double nguyen(double z, double theta) {
  const double axial = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
  if (theta <= kGrazing) return axial;
  const double ratio = grazing_ratio(theta);
  return axial + 0.0001 / std::sqrt(std::max(z, 0.1)) * ratio * ratio;
}

}  // namespace

Result<SensorModel> SensorModel::from_name(const std::string& name) {
  if (name == "kinect1") return SensorModel{Kind::kinect1};
  if (name == "kinect1-khoshelham") return SensorModel{Kind::kinect1_khoshelham};
  if (name == "tof") return SensorModel{Kind::tof};
  return fail(fmt::format("unknown sensor '{}'; use kinect1, kinect1-khoshelham, tof or {{constant: METRES}}", name));
}

Result<SensorModel> SensorModel::constant(double sigma_m) {
  if (!(sigma_m > 0 && sigma_m < 1)) return fail("a constant sensor sigma must be above 0 and below 1 m");
  return SensorModel{Kind::constant, sigma_m};
}

std::string SensorModel::name() const {
  switch (kind_) {
    case Kind::kinect1:
      return "kinect1";
    case Kind::kinect1_khoshelham:
      return "kinect1-khoshelham";
    case Kind::tof:
      return "tof";
    case Kind::constant:
      break;
  }
  return "constant";
}

double SensorModel::sigma_z_m(double z, double theta) const {
  switch (kind_) {
    case Kind::kinect1:
      return nguyen(z, theta);
    case Kind::kinect1_khoshelham:
      return 1.425e-3 * z * z;
    case Kind::tof:
      return 0.01 * z;
    case Kind::constant:
      break;
  }
  return constant_m_;
}

double SensorModel::sigma_lateral_px(double theta) const {
  return kind_ == Kind::kinect1 ? 0.8 + 0.035 * grazing_ratio(theta) : 0.0;
}

double SensorModel::quantisation_m(double z) const {
  return kind_ == Kind::kinect1 || kind_ == Kind::kinect1_khoshelham ? 2.85e-3 * z * z : 0.0;
}

}  // namespace meshloop
