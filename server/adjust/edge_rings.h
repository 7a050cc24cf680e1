#pragma once
// Do the outlines of the whole picture stand beside where the model has them?
#include <vector>

#include "common/change/comparison.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop {

/// Where the expected picture has an outline, and how far beside it the measured one stands.
struct OutlineShift {
  /// Pixel of the nearer surface.
  int x = 0;
  int y = 0;
  /// Expected depth of the nearer surface, metres.
  double near_z_m = 0;
  /// Across the outline in the picture, towards the farther surface, of length one.
  Eigen::Vector2d across = Eigen::Vector2d::Zero();
  /// Pixels along `across`: above 0 where the nearer surface reaches too far (a ring of closer pixels), below 0 where
  /// it is seen through (a ring of farther ones). Nothing to go by (what was there is gone): not a number.
  double shift_px = 0;
  /// Which thing it belongs to: outlines that hang together in the picture, of one node. From 0.
  int thing = 0;
};
[[nodiscard]] std::vector<OutlineShift> outline_shifts(const Comparison& comparison, const DepthImage& measured,
                                                       const SensorModel& sensor);

/// What the outlines say of the camera. A camera that stands elsewhere than its pose says rings all outlines, closer on
/// one side and farther on the other, as one motion explains; what moved rings its own alone, and the outlines of what
/// stayed contradict.
struct EdgeRings {
  /// Outline pixels that were looked at, and shares of them: at their place; ringed with closer and with farther
  /// pixels.
  int outlines = 0;
  double at_place = 0;
  double ringed_closer = 0;
  double ringed_farther = 0;
  /// The motion of the camera that explains most: exp(motion) takes points of the camera to where the pose expects
  /// them. Metres and radians.
  Twist motion = Twist::Zero();
  /// The share of outlines that it would shift visibly, and of those the shares that stand where it puts them, and
  /// that stand still.
  double shifted = 0;
  double explained = 0;
  double contradicted = 0;
  /// Things of which shifted outlines are explained, and the share of these that one thing has at most.
  int things = 0;
  double largest_thing = 1;

  /// One motion of the camera explains what is ringed all over the picture: the pose is wrong.
  [[nodiscard]] bool is_misregistered() const;
};
/// Pure; the images have the camera's size.
[[nodiscard]] EdgeRings find_edge_rings(const Comparison& comparison, const DepthImage& measured, const Camera& camera,
                                        const SensorModel& sensor);

}  // namespace meshloop
