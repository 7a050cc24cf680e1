#pragma once
#include "common/geometry/camera.h"

namespace meshloop::test {

/// A Kinect's view, also at another number of pixels.
inline Camera kinect_camera(int width = 640, int height = 480) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 585.0 * width / 640;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  return camera;
}

}  // namespace meshloop::test
