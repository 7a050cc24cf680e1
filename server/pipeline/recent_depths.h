#pragma once
#include <cstddef>
#include <deque>
#include <vector>

#include "server/adjust/depth_fusion.h"
#include "server/pipeline/tracked_frames.h"

namespace meshloop {

/// The depth of the last frames whose pose is good enough for new surface. One thread.
class RecentDepths {
 public:
  /// `most`: frames of a snapshot, its own included; 1 keeps none.
  explicit RecentDepths(std::size_t most) : most_{most} {}

  void add(const TrackedFrame& frame);
  /// Of frames before `frame`, the newest first, from `oldest_index` on. Valid until the next `add`.
  [[nodiscard]] std::vector<DepthView> before(const TrackedFrame& frame, int oldest_index) const;

 private:
  struct Kept {
    int index;
    DepthImage depth;
    Pose T_camera_world;
    PoseCovariance covariance;
  };
  std::size_t most_;
  std::deque<Kept> kept_;
};

/// The frame since which all regions that ask for new surface have been there: what was measured before is of another
/// state of the world.
[[nodiscard]] int first_frame_of(const RegionMap& regions, int frame_index);

}  // namespace meshloop
