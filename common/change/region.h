#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/change/label.h"
#include "common/image/image.h"

namespace meshloop {

using RegionId = std::uint32_t;

/// A connected piece of change of one kind.
struct Region {
  /// From 1; the same piece of the world keeps its id from frame to frame.
  RegionId id = 0;
  ChangeKind kind = ChangeKind::none;
  int pixels = 0;
  double area_m2 = 0;
  /// Over pixels where the model has a surface; 0 when it has none there. Signed like the difference.
  double mean_difference_m = 0;
  double max_difference_m = 0;
  /// Mean of |difference| / sigma; how far above the noise it stands.
  double significance = 0;
  /// In pixels of the depth image: first and last column and row.
  Eigen::AlignedBox2i pixel_box;
  /// In the world.
  Eigen::AlignedBox3d world_box;
  /// Mean of its points, in the world.
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  /// In how many frames it has been seen, and from how many views (RegionOptions says what makes a view new).
  int frames_seen = 0;
  int views_seen = 0;
  /// Seen often enough to be offered.
  bool confirmed = false;
};

/// The regions of one frame, and which pixel belongs to which.
struct RegionMap {
  /// Region id at each pixel; 0 where there is none.
  Image<RegionId> ids;
  std::vector<Region> regions;
};

}  // namespace meshloop
