#pragma once
// The colours of a patch as a picture in the depth camera's pixels.
#include <cstdint>
#include <memory>
#include <span>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/mesh/texture.h"
#include "server/adjust/color_lookup.h"
#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {

/// Of libjpeg. README.md, "A texture", has the figures that it was chosen by.
inline constexpr int kTextureQuality = 85;

/// The pinhole camera whose pixels a grid's window is of, and where new surface is placed with.
struct PlacedCamera {
  const Camera& camera;
  Pose T_camera_world = Pose::Identity();
};

/// The picture of a grid's window, and the projection from the world into it. `pixels`: those of the window that the
/// patch uses. Each has the colour that the lookup finds for its depth, without rounding; where it finds none, that of
/// the nearest pixel that has one (breadth first, over the patch before all else), mid grey when there is none. All
/// other pixels continue the nearest of the patch, so that what is sampled at the patch's border has its colours. Null
/// when the picture has more pixels or its JPEG more bytes than a texture may.
[[nodiscard]] std::shared_ptr<const ProjectedTexture> make_patch_texture(const DepthGrid& grid,
                                                                         std::span<const std::uint32_t> pixels,
                                                                         const PlacedCamera& placed,
                                                                         const ColorLookup& lookup);

}  // namespace meshloop::adjust
