#pragma once
// Noise of depth sensors: the standard deviation of one measurement along the optical axis, in metres.
#include <Eigen/Core>
#include <span>
#include <string>

#include "common/base/result.h"

namespace meshloop {

/// The numbers of a sensor model, as the comparison's shader gets them.
struct SensorNoise {
  /// Axial sigma in metres: c0 + c1 z + c2 z^2, quantisation included.
  Eigen::Vector3d axial = Eigen::Vector3d::Zero();
  /// Where the polynomial holds. Nearer it keeps the value at `nearest_m`; farther it grows with the square of depth.
  double nearest_m = 0;
  double farthest_m = 1e6;
  /// Adds Nguyen's term for surfaces seen at more than 60 degrees from their normal.
  bool grows_at_grazing = false;
  /// Two depths that the sensor can tell apart are step_per_m * z^2 apart; 0 when it is not coarser than its noise.
  double step_per_m = 0;
  /// Sigma across the optical axis, in pixels: lateral_px + lateral_growth_px * theta / (pi/2 - theta).
  double lateral_px = 0;
  double lateral_growth_px = 0;
};

/// z: depth in metres. theta: angle between the ray and the surface normal, in radians, below pi/2.
class SensorModel {
 public:
  enum class Kind { kinect1, kinect1_khoshelham, tof, constant, measured };

  SensorModel() : SensorModel{Kind::kinect1} {}
  /// Of Kind::measured only `measured` makes a useful model.
  explicit SensorModel(Kind kind, double constant_m = 0);
  /// "kinect1", "kinect1-khoshelham" or "tof"; a constant is made by `constant`.
  [[nodiscard]] static Result<SensorModel> from_name(const std::string& name);
  /// `sigma_m` metres at every depth, and no lateral noise.
  [[nodiscard]] static Result<SensorModel> constant(double sigma_m);
  /// As measured from a scene at rest. Refuses a sigma that is not above 0 and below 1 m all over the range, a range
  /// outside 0.01 to 100 m, steps of more than 0.1 per metre and more than 20 lateral pixels.
  [[nodiscard]] static Result<SensorModel> measured(const SensorNoise& noise);

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] std::string name() const;
  [[nodiscard]] const SensorNoise& noise() const { return noise_; }

  /// kinect1: Nguyen, Izadi, Lovell 2012, equations 3 to 5. kinect1-khoshelham: Khoshelham, Elberink 2012, section
  /// 3.2. tof: 1 % of the distance.
  [[nodiscard]] double sigma_z_m(double z_m, double theta) const;
  /// The same for surfaces seen frontally, many at once; as many sigmas as depths.
  void frontal_sigmas_m(std::span<const float> z_m, std::span<float> sigmas_m) const;
  /// Variance of the mean of `frames` measurements at rest: the noise becomes less, the share of the quantisation does
  /// not, since a pixel at rest may deliver the same step each time. One frame has sigma_z_m squared.
  [[nodiscard]] double variance_m2(double z_m, double theta, int frames) const;
  /// Standard deviation across the optical axis, in pixels (Nguyen 2012, equation 1; 0 for the models without).
  [[nodiscard]] double sigma_lateral_px(double theta) const;
  /// Distance between two depths that the sensor can tell apart; 0 when it is not coarser than its noise.
  [[nodiscard]] double quantisation_m(double z_m) const;
  /// Of Kind::constant.
  [[nodiscard]] double constant_m() const { return kind_ == Kind::constant ? noise_.axial[0] : 0; }

 private:
  Kind kind_;
  SensorNoise noise_;
};

}  // namespace meshloop
