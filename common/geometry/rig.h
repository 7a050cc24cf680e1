#pragma once
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/geometry/sensor_model.h"

namespace meshloop {

/// A rigidly coupled pair of a depth and a colour camera.
struct Rig {
  Camera color;
  Camera depth;
  /// Metres per unit of the recorded depth images, whole numbers or float; at most 1.
  double depth_scale = 0.001;
  Pose T_depth_color = Pose::Identity();
  SensorModel sensor;
  /// True: depth already lies in the colour camera's pixels.
  bool depth_registered = false;
};

[[nodiscard]] Status validate(const Rig& rig);

}  // namespace meshloop
