#pragma once
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "server/adjust/depth_fusion.h"
#include "server/pipeline/tracked_frames.h"

namespace meshloop {

/// The depth of the last frames whose pose is good enough for new surface. Copies share the images. One thread.
class RecentDepths {
 public:
  /// `most`: frames of a snapshot, its own included; 1 keeps none.
  explicit RecentDepths(std::size_t most) : most_{most} {}

  void add(const TrackedFrame& frame);
  /// Picture or model spoke against this frame's pose, or against the last ones': new surface is not made of them.
  void drop(int index);
  void clear() { kept_.clear(); }
  /// Of frames before `frame`, the newest first, from `oldest_index` on. Valid until the next change.
  [[nodiscard]] std::vector<DepthView> before(const TrackedFrame& frame, int oldest_index) const;

 private:
  struct Kept {
    int index;
    std::shared_ptr<const DepthImage> depth;
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
