#pragma once
// A snapshot as the search for moves sees it: each move that was found changes what is looked at after it.
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "server/adjust/depth_buffer.h"
#include "server/adjust/part.h"
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// How far a measurement may lie from a surface that it is of: three sigma.
class Tolerance {
 public:
  explicit Tolerance(const Snapshot& snapshot);

  /// Metres along the optical axis. Of a plane through `point` in the camera's frame, with a unit normal: noise of the
  /// sensor along and across the axis, and of the snapshot's pose.
  [[nodiscard]] double at(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

 private:
  const Camera* camera_;
  const SensorModel* sensor_;
  double position_variance_m2_;
  double angle_variance_;
};

/// A part that was found to stand elsewhere.
struct MovedPart {
  Part part;
  Pose T_camera_node;
};

/// All images have the depth camera's size.
struct MoveScene {
  /// The snapshot must be valid and outlive this.
  explicit MoveScene(const Snapshot& seen);

  const Snapshot* snapshot;
  Tolerance tolerance;
  /// What is expected with the moves that were found so far.
  DepthImage expected;
  Image<std::uint32_t> node_index;
  Image<float> threshold_m;
  /// Pixels of the confirmed regions that no move has explained yet; 0 elsewhere.
  Image<RegionId> open;
  std::vector<MovedPart> moved;
  /// Regions that these have closed; no other move can.
  std::vector<RegionId> closed;

  [[nodiscard]] const Camera& camera() const { return snapshot->rig->depth; }
  [[nodiscard]] Pose T_camera_node(std::size_t node_position) const {
    return snapshot->depth_pose.T_camera_world * snapshot->model->nodes[node_position].T_world_node;
  }
  /// Metres; 0 where nothing usable is measured.
  [[nodiscard]] float measured(int x, int y) const;
  [[nodiscard]] ChangeKind kind_of_region(RegionId id) const;
  /// Pixels at 640x480 as as many at this picture's size.
  [[nodiscard]] double scaled_pixels(double pixels) const;
};

/// Unit normal in the camera's frame of the triangle of a part that a pixel of its buffer shows.
[[nodiscard]] Eigen::Vector3d normal_of(const Part& part, const Pose& T_camera_node, std::uint32_t triangle);

}  // namespace meshloop::adjust
