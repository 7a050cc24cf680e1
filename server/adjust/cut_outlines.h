#pragma once
// Which large triangles lose a part of themselves, and along which lines.
#include <cstdint>
#include <map>
#include <vector>

#include "server/adjust/proposal.h"
#include "server/adjust/visible_surface.h"

namespace meshloop::adjust {

/// A node's triangles by what the picture can tell of them.
struct LargeTriangles {
  /// Those that are more than a few pixels long.
  std::vector<bool> is_large;
  /// Of these, those that some pixel near a removal region shows. They are cut; others go or stay as they are.
  std::vector<bool> is_shown;
  /// What each confirmed removal region takes away of them.
  std::map<RegionId, CutOutlines> by_region;
};

/// The snapshot must be valid, and `surface` be made of it.
[[nodiscard]] LargeTriangles find_cut_outlines(const Snapshot& snapshot, const VisibleSurface& surface,
                                               std::size_t node_position);

}  // namespace meshloop::adjust
