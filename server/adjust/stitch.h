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

struct Stitched {
  /// Vertices of the patch that lie where the model has a border vertex, or on a border edge; at the end of its
  /// vertices.
  std::vector<std::uint32_t> vertices;
  /// Border vertices of the patch that lay beside a border of the model, and how many of these are joined now.
  std::size_t beside = 0;
  std::size_t joined = 0;
};

/// Where the patch's border runs beside an open border of the model, the triangles at the patch's border are made anew
/// so that they end in the model's own border vertices: no gap, no overlap, no vertex of one side on an edge of the
/// other. The model stays as it is. `border` has the directed edges of the patch's border, its surface on their left.
/// Where the outlines cross each other more than that can mend, the patch stays as it was. Patch in the world; vertices
/// that nothing uses any more stay in it. New ones have the colour of the model's border, or of the patch beside.
Stitched stitch(Submesh& patch, std::vector<std::array<std::uint32_t, 2>> border, const Model& model,
                const StitchView& view);

}  // namespace meshloop::adjust
