#pragma once
// The model around a view, as planes that measured points are fitted to.
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/change/comparison.h"
#include "common/geometry/camera.h"
#include "common/geometry/sensor_model.h"

namespace meshloop::adjust {

/// The expected depth of a comparison, in its camera's frame: a plane for each pixel, made when it is asked for. What
/// it is made from must outlive it. One thread.
class ExpectedPlanes {
 public:
  using Plane = Eigen::Hyperplane<double, 3>;

  ExpectedPlanes(const Comparison& comparison, const Camera& camera, const SensorModel& sensor);

  /// At the pixel that shows the point (in the camera's frame, metres); null beside a bend or an outline that the
  /// sensor could tell, outside the picture, and where the model has no surface. Valid until this ends.
  [[nodiscard]] const Plane* at(const Eigen::Vector3d& p);

 private:
  enum class State : std::uint8_t { unknown, none, plane };

  [[nodiscard]] bool make(int x, int y, Plane& plane) const;
  [[nodiscard]] Eigen::Vector3d point(int x, int y) const;
  [[nodiscard]] bool is_straight(int x, int y, int dx, int dy) const;

  const Comparison& comparison_;
  const Camera& camera_;
  const SensorModel& sensor_;
  std::vector<Plane> planes_;
  std::vector<State> states_;
};

}  // namespace meshloop::adjust
