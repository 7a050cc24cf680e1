#pragma once
// Noise of depth sensors: the standard deviation of one measurement along the optical axis, in metres.
#include <string>

#include "common/base/result.h"

namespace meshloop {

/// z: depth in metres. theta: angle between the ray and the surface normal, in radians, below pi/2.
class SensorModel {
 public:
  enum class Kind { kinect1, kinect1_khoshelham, tof, constant };

  SensorModel() = default;
  explicit SensorModel(Kind kind, double constant_m = 0) : kind_{kind}, constant_m_{constant_m} {}
  /// "kinect1", "kinect1-khoshelham" or "tof"; a constant is made by `constant`.
  [[nodiscard]] static Result<SensorModel> from_name(const std::string& name);
  /// `sigma_m` metres at every depth, and no lateral noise.
  [[nodiscard]] static Result<SensorModel> constant(double sigma_m);

  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] std::string name() const;

  /// kinect1: Nguyen, Izadi, Lovell 2012, equations 3 to 5. kinect1-khoshelham: Khoshelham, Elberink 2012, section
  /// 3.2. tof: 1 % of the distance.
  [[nodiscard]] double sigma_z_m(double z_m, double theta) const;
  /// Standard deviation across the optical axis, in pixels (Nguyen 2012, equation 1; 0 for the other models).
  [[nodiscard]] double sigma_lateral_px(double theta) const;
  /// Distance between two depths that the sensor can tell apart; 0 when it is not coarser than its noise.
  [[nodiscard]] double quantisation_m(double z_m) const;
  /// Value for the shader's `sensor_kind`, and the constant of Kind::constant.
  [[nodiscard]] int shader_kind() const { return static_cast<int>(kind_); }
  [[nodiscard]] double constant_m() const { return constant_m_; }

 private:
  Kind kind_ = Kind::kinect1;
  double constant_m_ = 0;
};

}  // namespace meshloop
