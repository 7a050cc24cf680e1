#include "server/pipeline/recent_depths.h"

#include <algorithm>

namespace meshloop {

void RecentDepths::add(const TrackedFrame& frame) {
  if (most_ <= 1) return;
  kept_.push_back({frame.frame.index, std::make_shared<const DepthImage>(frame.frame.depth),
                   frame.depth_pose.T_camera_world, frame.depth_pose.covariance});
  // The newest one may be the snapshot's own frame.
  if (kept_.size() > most_) kept_.pop_front();
}

void RecentDepths::drop(int index) {
  std::erase_if(kept_, [&](const Kept& kept) { return kept.index == index; });
}

std::vector<DepthView> RecentDepths::before(const TrackedFrame& frame, int oldest_index) const {
  std::vector<DepthView> views;
  for (auto kept = kept_.rbegin(); kept != kept_.rend() && views.size() + 1 < most_; ++kept) {
    if (kept->index >= frame.frame.index || kept->index < oldest_index) continue;
    views.push_back({kept->depth.get(), kept->T_camera_world, kept->covariance});
  }
  return views;
}

int first_frame_of(const RegionMap& regions, int frame_index) {
  int first = 0;
  for (const auto& region : regions.regions) {
    if (region.confirmed && region.kind == ChangeKind::insertion) {
      first = std::max(first, frame_index - region.frames_seen + 1);
    }
  }
  return first;
}

}  // namespace meshloop
