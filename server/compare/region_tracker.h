#pragma once
#include <vector>

#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace meshloop {

struct RegionOptions {
  /// Smaller regions are noise. In pixels at 640x480; scaled with the image's area.
  int min_pixels = 60;
  /// And this large in the world.
  double min_area_m2 = 1e-4;
  /// Seen from this many views before it is offered. A view is new when the camera moved so far since the last one that
  /// an error which sticks to the camera's pixels would lie elsewhere in the world by now, by new_view_px at least
  /// (more for large regions), and the region's centre has not moved along.
  int confirm_views = 3;
  /// In pixels at 640x480; scaled with the image's width.
  double new_view_px = 8;
  /// A camera that rests gives no new views, and a region that the picture's border cuts shows none; then it takes this
  /// many frames. A region that moves along with the camera
  /// begins again.
  int confirm_frames_at_rest = 8;
  /// Unless the region is this many times as significant as the threshold asks: errors that stick are no more than a
  /// few sigma. Then confirm_views frames are enough.
  double strong_significance = 2;
  /// How many sigma the comparison's thresholds stand for; a region's significance follows from it.
  double sigmas_per_threshold = 3;
  /// A region that was not seen for this many frames is forgotten: 5 when it was never confirmed.
  int forget_after_frames = 300;
};

/// Groups changed pixels into regions and follows them from frame to frame (ids are stable, by overlap in the world).
///
/// A region's surface is the measured one where something was inserted and the expected one where something was
/// removed: its area and its world box are those of the thing that came or went. A region map holds all regions of the
/// frame that are large enough, in the order of their ids, confirmed or not; only changed pixels carry an id.
class RegionTracker {
 public:
  explicit RegionTracker(const RegionOptions& options) : options_{options} {}
  /// Frames in the order of time. T_camera_world and camera are the depth camera's. All images have one size; when they
  /// do not, the map is empty.
  /// `frames`: of how many the comparison's depth is the mean.
  RegionMap update(const Comparison& comparison, const DepthImage& measured, const Camera& camera,
                   const Pose& T_camera_world, int frames = 1);
  /// Forgets all (after the model changed, the regions are other ones). Ids go on from where they were.
  void reset();

 private:
  struct Known {
    Region region;
    int frames_unseen = 0;
    int frames_at_rest = 0;
    /// Of the last view that counted.
    Pose T_camera_world;
    Eigen::Vector3d centre_world;
  };
  /// Where the camera is, and how many frames the sight of it stands for.
  struct View {
    Camera camera;
    Pose T_camera_world;
    int frames = 1;
  };
  void recognise(std::vector<Region>& regions, const View& view);
  void count_view(Region& region, Known& known, const View& view) const;
  void forget();

  RegionOptions options_;
  std::vector<Known> known_;
  RegionId next_id_ = 1;
};

/// Changed pixels that belong to no region become `undecided`: a few pixels alone, as along the outline of a model that
/// is a fraction of a pixel off, cannot be told from noise.
void settle_labels(Comparison& comparison, const RegionMap& regions);

}  // namespace meshloop
