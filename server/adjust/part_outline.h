#pragma once
// The edge of a part in the picture, and how far off it is measured.
#include <Eigen/Core>
#include <vector>

#include "server/adjust/without_part.h"

namespace meshloop::adjust {

/// A pixel of the part's edge.
struct OutlinePoint {
  /// On the part, in the camera's frame.
  Eigen::Vector3d point;
  /// Outwards, in the picture; unit length.
  Eigen::Vector2d outwards;
  /// How far outwards the edge is measured, in pixels.
  double off_px;
};

/// Of the part at this pose, where it stands before something farther away by more than noise and a measured edge is
/// within `reach_px`.
[[nodiscard]] std::vector<OutlinePoint> find_outline(const MoveScene& scene, const Part& part,
                                                     const WithoutPart& without, const Pose& T_camera_node,
                                                     int reach_px);

}  // namespace meshloop::adjust
