#pragma once
// Things on a table, before and after somebody was there: a Kinect's view of what is, compared with a model of what
// was.
#include <cstdint>
#include <memory>
#include <optional>

#include "common/simulation/scene.h"
#include "server/adjust/proposal.h"

namespace meshloop::moved_things {

struct View {
  /// 640x480 pixels, as a Kinect has.
  Pose T_world_depth;
  /// 0: exact depth.
  double noise = 1;
  std::uint64_t seed = 1;
};

/// All that a snapshot points to.
struct World {
  Rig rig;
  Model model;
  RgbdFrame frame;
  Comparison comparison;
  RegionMap regions;
  Pose T_depth_world;

  [[nodiscard]] Snapshot snapshot() const;
};

/// The model has what is `modelled` in `before`: a node an object, in their order, ids from 1, edges up to 1 cm on
/// boxes that `box_on_table` made and 10 cm elsewhere.
/// Compared at three sigma, and grouped into regions, as the station does; all regions are confirmed.
[[nodiscard]] std::unique_ptr<World> look(const simulation::Scene& before, const simulation::Scene& after,
                                          const View& view);

/// A box on the table (its top is z = 0), turned about the vertical. With a printed texture, or of one colour.
[[nodiscard]] simulation::Solid box_on_table(const Eigen::Vector3d& size, double x, double y, double turn_degrees,
                                             bool has_print, std::uint64_t seed);
/// A cylinder of this diameter and height.
[[nodiscard]] simulation::Solid can_on_table(double diameter, double height, double x, double y);

/// A table in a room, with two things at its far end. With prints, or of plain colours.
[[nodiscard]] simulation::Scene table(bool has_prints);

/// From before the table, looking at a point 5 cm above its middle.
[[nodiscard]] Pose camera_at(double distance_m, double azimuth_degrees, double elevation_degrees);

}  // namespace meshloop::moved_things
