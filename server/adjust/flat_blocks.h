#pragma once
// A depth image as small flat pieces: less noise, and a normal for each.
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop::adjust {

/// What a block of pixels measured of one plane, in the camera's frame, metres.
struct FlatBlock {
  /// On the plane, at the middle of the block.
  Eigen::Vector3d point;
  /// Away from the camera, of length one.
  Eigen::Vector3d normal;
  /// Of the point along the normal.
  double sigma_m = 0;
  /// Of the normal, radians squared, for each of the two directions in which it may lean.
  double normal_variance = 0;
};

/// Blocks that are measured all over and bend no more than the sensor's noise shows. A block is 8 pixels wide in an
/// image of 640, and never less than 4.
class FlatBlocks {
 public:
  /// Pixels of one block err together, so that ten of them count as one (see the README's "Poses of several frames").
  FlatBlocks(const DepthImage& depth, const Camera& camera, const SensorModel& sensor);

  [[nodiscard]] const std::vector<FlatBlock>& all() const { return blocks_; }
  /// The block that shows the point (in the camera's frame); null where there is none.
  [[nodiscard]] const FlatBlock* at(const Eigen::Vector3d& p) const;

 private:
  const Camera* camera_;
  int side_px_;
  int columns_;
  int rows_;
  std::vector<FlatBlock> blocks_;
  /// By block of the image: position in blocks_, or -1.
  std::vector<int> positions_;
};

}  // namespace meshloop::adjust
