#pragma once
#include "server/adjust/proposal.h"

namespace meshloop::test {

/// Of a test's world: model, frame, rig, comparison, regions and T_depth_world, which must outlive it.
template <class World>
[[nodiscard]] Snapshot snapshot_of(const World& world) {
  Snapshot snapshot;
  snapshot.model = &world.model;
  snapshot.frame = &world.frame;
  snapshot.rig = &world.rig;
  snapshot.depth_pose.state = TrackState::tracking;
  snapshot.depth_pose.T_camera_world = world.T_depth_world;
  snapshot.comparison = &world.comparison;
  snapshot.regions = &world.regions;
  return snapshot;
}

}  // namespace meshloop::test
