#pragma once
#include <cstdint>
#include <vector>

#include "server/adjust/depth_grid.h"
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// How a point of a node lies to the surface that the depth camera is expected to see.
enum class Sight : std::uint8_t {
  outside,  ///< not in the picture, or behind the camera
  hidden,   ///< behind another surface
  clear     ///< it is the surface that is seen, or lies right at that surface's silhouette
};

struct Sighting {
  Sight sight = Sight::outside;
  /// The confirmed removal region that sees through the point; 0 when none does.
  RegionId seen_through = 0;
};

/// Asks the comparison's images about single points of the model.
///
/// At a silhouette no pixel is certain by itself (its threshold is infinite or wide), so that a removed surface would
/// leave its outline standing. Therefore up to two undecided pixels beside a removal region count with it, when they
/// show the same node, and are seen through by more than the region's threshold there.
class VisibleSurface {
 public:
  /// The snapshot must be valid and outlive this.
  explicit VisibleSurface(const Snapshot& snapshot);

  /// A point in the world, on the node at `node_position` of Model::nodes.
  [[nodiscard]] Sighting look_at(const Eigen::Vector3d& p_world, std::size_t node_position) const;

  /// The confirmed removal region that a pixel speaks for; 0 for none.
  [[nodiscard]] RegionId evidence(int x, int y) const { return evidence_(x, y); }
  /// Around all such pixels, with a margin; empty when there are none.
  [[nodiscard]] const Window& evidence_window() const { return evidence_window_; }
  /// A point at this depth is seen through at a pixel that speaks for a region.
  [[nodiscard]] bool is_seen_through(int x, int y, double z) const;

  /// What is expected at the pixel is this node's surface, at about this depth: within 1 cm, as it was drawn twice.
  [[nodiscard]] bool is_expected(int x, int y, std::size_t node_position, double z) const;

  /// Positions in Model::nodes that a confirmed removal region shows.
  [[nodiscard]] std::vector<std::size_t> nodes_in_removal_regions() const;

 private:
  [[nodiscard]] bool shows(int x, int y, std::uint32_t node_index, double z) const;
  [[nodiscard]] double tolerance(int x, int y) const;

  void start_evidence();
  void grow_evidence();
  void find_evidence_window();

  const Snapshot* snapshot_;
  /// Sorted.
  std::vector<RegionId> removal_ids_;
  /// The confirmed removal region that each pixel speaks for, 0 for none, and the difference it must exceed.
  Image<RegionId> evidence_;
  Window evidence_window_;
  Image<float> threshold_m_;
};

}  // namespace meshloop::adjust
