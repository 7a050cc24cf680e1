#pragma once
// A depth image as square pieces of surface. Pure functions.
#include <array>
#include <cstdint>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop::show {

/// A square of 1, 2, 4 or 8 pixels a side, all of them measured and on one surface.
struct Block {
  int x = 0;
  int y = 0;
  int size = 1;
  /// Inverse depth (1/m) at the outer corners of its outer pixels, half a pixel beyond their centres: upper left, upper
  /// right, lower left, lower right. Blocks that touch on one surface share these values.
  std::array<float, 4> inverse_depth{};
};

struct BlockRules {
  /// Of the depth image. Two neighbours lie on one surface when their depths differ by no more than those of a plane
  /// seen at 80 degrees, and the noise of the sensor.
  Camera camera;
  SensorModel sensor;
  /// How far (1/m) a pixel may lie from the plane of its block, where that is more than the noise.
  float flatness_per_m = 0;
};

/// Blocks that cover exactly the pixels with a depth, as large as the rules allow.
[[nodiscard]] std::vector<Block> make_blocks(const DepthImage& depth, const BlockRules& rules);

}  // namespace meshloop::show
