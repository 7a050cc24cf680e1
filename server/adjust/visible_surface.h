#pragma once
#include <cstdint>
#include <vector>

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
class VisibleSurface {
 public:
  /// The snapshot must be valid and outlive this.
  explicit VisibleSurface(const Snapshot& snapshot);

  /// A point in the world, on the node at `node_position` of Model::nodes.
  [[nodiscard]] Sighting look_at(const Eigen::Vector3d& p_world, std::size_t node_position) const;

  /// Positions in Model::nodes that a confirmed removal region shows.
  [[nodiscard]] std::vector<std::size_t> nodes_in_removal_regions() const;

 private:
  [[nodiscard]] bool shows(int x, int y, std::uint32_t node_index, double z) const;
  [[nodiscard]] double tolerance(int x, int y) const;
  [[nodiscard]] RegionId region_that_sees_through(int x, int y, double z) const;

  const Snapshot* snapshot_;
  /// By region id.
  std::vector<RegionId> removal_ids_;
};

}  // namespace meshloop::adjust
