#pragma once
// A new patch and the surfaces that the model ends with beside it become one surface.
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/geometry/camera.h"
#include "common/mesh/model.h"

namespace meshloop::adjust {

struct StitchView {
  const Camera* camera = nullptr;
  /// The pose that the model was compared with.
  Eigen::Isometry3f T_camera_world = Eigen::Isometry3f::Identity();
  /// Standard deviation of a depth, of most of the patch.
  float sigma_m = 0;
};

/// Gaps and overlaps up to so many pixels across the picture are closed, and steps up to four sigma of depth.
inline constexpr double kStitch_px = 4;

/// Where the patch's border runs beside an open border of the model, the triangles at the patch's border are made anew
/// so that they end in the model's own border vertices: no gap, no overlap, no vertex of one side on an edge of the
/// other. The model stays as it is. `border` has the directed edges of the patch's border, its surface on their left.
/// Where the outlines cross each other more than that can mend, the patch stays as it was. Patch in the world; vertices
/// that nothing uses any more stay in it. Returns the new ones, which lie where the model has a border vertex (or,
/// where it has none near, on a border edge): to the bit when that node's vertices lie on the world's lattice, else,
/// since the patch is put onto the lattice, within half of its spacing. They have the colour of the model's border, or
/// of the patch beside.
std::vector<std::uint32_t> stitch(Submesh& patch, std::vector<std::array<std::uint32_t, 2>> border, const Model& model,
                                  const StitchView& view);

}  // namespace meshloop::adjust
