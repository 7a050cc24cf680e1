#include "common/geometry/sensor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/target_clones.h"

namespace meshloop {
namespace {

constexpr double kGrazing = std::numbers::pi / 3;       // Nguyen's second term counts above 60 degrees
constexpr double kLimit = 80 * std::numbers::pi / 180;  // beyond, the Kinect measures nothing
// Khoshelham 2012, equation 13 and section 3.2: one unit of disparity, in metres of depth at one metre.
constexpr double kKinectStep = 2.85e-3;

double grazing_ratio(double theta) {
  const double t = std::clamp(theta, 0.0, kLimit);
  return t / (std::numbers::pi / 2 - t);
}

double polynomial(const Eigen::Vector3d& c, double z) {
  return c[0] + z * (c[1] + z * c[2]);
}

SensorNoise noise_of(SensorModel::Kind kind, double constant_m) {
  SensorNoise noise;
  switch (kind) {
    case SensorModel::Kind::kinect1:
      // 0.0012 + 0.0019 (z - 0.4)^2; the residuals it was fitted to are those of quantised depth.
      noise.axial = {0.0012 + 0.0019 * 0.4 * 0.4, -2 * 0.0019 * 0.4, 0.0019};
      noise.grows_at_grazing = true;
      noise.step_per_m = kKinectStep;
      noise.lateral_px = 0.8;
      noise.lateral_growth_px = 0.035;
      break;
    case SensorModel::Kind::kinect1_khoshelham:
      noise.axial = {0, 0, 1.425e-3};
      noise.step_per_m = kKinectStep;
      break;
    case SensorModel::Kind::tof:
      noise.axial = {0, 0.01, 0};
      break;
    case SensorModel::Kind::constant:
    case SensorModel::Kind::measured:
      noise.axial = {constant_m, 0, 0};
      break;
  }
  return noise;
}

// The extreme values of the polynomial over its range, at the ends or at the vertex between them.
std::pair<double, double> extremes(const SensorNoise& noise) {
  const Eigen::Vector3d& c = noise.axial;
  const double vertex = c[2] == 0 ? noise.nearest_m : -c[1] / (2 * c[2]);
  const double inside = std::clamp(vertex, noise.nearest_m, noise.farthest_m);
  return std::minmax({polynomial(c, noise.nearest_m), polynomial(c, inside), polynomial(c, noise.farthest_m)});
}

}  // namespace

SensorModel::SensorModel(Kind kind, double constant_m) : kind_{kind}, noise_{noise_of(kind, constant_m)} {}

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

Result<SensorModel> SensorModel::measured(const SensorNoise& noise) {
  if (!(noise.nearest_m >= 0.01 && noise.nearest_m <= noise.farthest_m && noise.farthest_m <= 100)) {
    return fail("the range of a measured sensor must go from near to far, within 0.01 to 100 m");
  }
  if (!noise.axial.allFinite()) return fail("the polynomial of a measured sensor must have finite numbers");
  const auto [least, most] = extremes(noise);
  if (!(least > 0 && most < 1)) {
    return fail(
        fmt::format("the sigma of a measured sensor must be above 0 and below 1 m all over its range, but goes "
                    "from {:.4g} to {:.4g} m",
                    least, most));
  }
  if (!(noise.step_per_m >= 0 && noise.step_per_m <= 0.1)) return fail("the step of a measured sensor is 0 to 0.1");
  if (!(noise.lateral_px >= 0 && noise.lateral_px <= 20))
    return fail("the lateral noise of a sensor is 0 to 20 pixels");
  SensorModel model{Kind::measured};
  model.noise_ = noise;
  return model;
}

std::string SensorModel::name() const {
  switch (kind_) {
    case Kind::kinect1:
      return "kinect1";
    case Kind::kinect1_khoshelham:
      return "kinect1-khoshelham";
    case Kind::tof:
      return "tof";
    case Kind::measured:
      return "measured";
    case Kind::constant:
      break;
  }
  return "constant";
}

namespace {

MESHLOOP_TARGET_CLONES
void axial_sigmas(const SensorNoise& noise, const float* z_m, std::size_t count, float* sigmas_m) {
  const double c0 = noise.axial[0];
  const double c1 = noise.axial[1];
  const double c2 = noise.axial[2];
  const double nearest_m = noise.nearest_m;
  const double farthest_m = noise.farthest_m;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = z_m[i];
    const double beyond = std::max(1.0, z / farthest_m);
    const double within = std::min(std::max(z, nearest_m), farthest_m);
    sigmas_m[i] = static_cast<float>((c0 + within * (c1 + within * c2)) * beyond * beyond);
  }
}

}  // namespace

void SensorModel::frontal_sigmas_m(std::span<const float> z_m, std::span<float> sigmas_m) const {
  axial_sigmas(noise_, z_m.data(), z_m.size(), sigmas_m.data());
}

double SensorModel::sigma_z_m(double z, double theta) const {
  const double beyond = std::max(1.0, z / noise_.farthest_m);
  const double axial = polynomial(noise_.axial, std::clamp(z, noise_.nearest_m, noise_.farthest_m)) * beyond * beyond;
  if (!noise_.grows_at_grazing || theta <= kGrazing) return axial;
  const double ratio = grazing_ratio(theta);
  return axial + 0.0001 / std::sqrt(std::max(z, 0.1)) * ratio * ratio;
}

double SensorModel::variance_m2(double z, double theta, int frames) const {
  const double sigma = sigma_z_m(z, theta);
  const double step = quantisation_m(z);
  const double lasting = std::min(step * step / 12, sigma * sigma);
  return (sigma * sigma - lasting) / std::max(frames, 1) + lasting;
}

double SensorModel::sigma_lateral_px(double theta) const {
  return noise_.lateral_px + noise_.lateral_growth_px * grazing_ratio(theta);
}

double SensorModel::quantisation_m(double z) const {
  return noise_.step_per_m * z * z;
}

}  // namespace meshloop
