#pragma once
#include "common/image/image.h"

namespace meshloop {

/// What a depth-and-colour rig delivers at one moment. Images are free of lens distortion (see Rectifier): every later
/// stage computes with pinhole cameras.
struct RgbdFrame {
  /// Position in the source, from 0, in the order of the depth images.
  int index = 0;
  double depth_timestamp_s = 0;
  double color_timestamp_s = 0;
  DepthImage depth;
  ColorImage color;
};

/// What a handheld's camera delivers. Free of lens distortion.
struct ColorFrame {
  int index = 0;
  double timestamp_s = 0;
  ColorImage color;
};

}  // namespace meshloop
