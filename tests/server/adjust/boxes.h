#pragma once
// Scenes of axis-aligned boxes with exact depth, and the snapshots that follow from what of them is modelled.
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <vector>

#include "server/adjust/proposal.h"

namespace meshloop::boxes {

struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  /// Where it is in the model: NodeId, or 0 when it is not modelled.
  NodeId node = 0;
  /// Stands in reality.
  bool real = true;
  /// Edge length of its triangles.
  double edge_m = 0.01;
};

/// Exact depth along the optical axis, and which box (position in the list, plus 1).
struct Cast {
  DepthImage depth;
  Image<std::uint32_t> box;
};
[[nodiscard]] Cast cast(const std::vector<Box>& boxes, const Camera& camera, const Pose& T_camera_world);

/// What a depth camera delivers of them, with all the faults that common/simulation gives it.
[[nodiscard]] DepthImage measure(const std::vector<Box>& boxes, const Camera& camera, const Pose& T_camera_world,
                                 const SensorModel& sensor, unsigned seed);

/// Triangles of all six faces, edges at most edge_m, faces with vertices of their own.
[[nodiscard]] Submesh tessellate(const Box& box);

/// All that a snapshot points to.
struct World {
  std::vector<Box> boxes;
  Rig rig;
  Pose T_depth_world = Pose::Identity();
  Model model;
  RgbdFrame frame;
  Comparison comparison;
  RegionMap regions;
  DepthImage truth;

  [[nodiscard]] Snapshot snapshot() const;
  /// First region of a kind; id 0 when there is none.
  [[nodiscard]] Region region(ChangeKind kind) const;
};

struct WorldOptions {
  Camera depth{320, 240, 290, 290, 159.5, 119.5, {}};
  Camera color{320, 240, 262, 262, 159.5, 119.5, {}};
  Pose T_depth_color = Pose::Identity();
  SensorModel sensor{SensorModel::Kind::constant, 0.001};
  /// Gaussian, in multiples of the sensor's sigma.
  double noise = 0;
  /// In place of that: `measure`.
  bool with_all_faults = false;
  unsigned seed = 1;
  double threshold_m = 0.005;
  /// In place of that, when not 0: so many sigma of the sensor at what is expected.
  double threshold_sigmas = 0;
  /// Colour of a point of the world; the colour image is cast from the real boxes.
  std::function<Rgb8(const Eigen::Vector3d&)> paint = [](const Eigen::Vector3d&) { return Rgb8{200, 100, 50}; };
};

/// Casts, compares with a fixed threshold and groups into confirmed regions.
[[nodiscard]] std::unique_ptr<World> make_world(std::vector<Box> boxes, const Pose& T_world_depth,
                                                const WorldOptions& options = {});

}  // namespace meshloop::boxes
