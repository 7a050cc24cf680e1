#pragma once
// A payload with a texture, little-endian: "MTX1", bytes of the mesh (uint32), the projection (12 float32, column by
// column), the mesh, the JPEG. A payload without one is the mesh alone, which starts with "DRACO".
#include <cstddef>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/mesh/texture.h"

namespace meshloop {

/// A payload's parts, as views into its bytes.
struct TextureFrame {
  std::span<const std::byte> mesh;
  TextureProjection projection;
  std::span<const std::byte> jpeg;
};

[[nodiscard]] bool is_texture_frame(std::span<const std::byte> payload);
/// Refuses what ends before its parts do. The parts are not looked at.
[[nodiscard]] Result<TextureFrame> split_texture_frame(std::span<const std::byte> payload);
[[nodiscard]] std::vector<std::byte> join_texture_frame(std::span<const std::byte> mesh,
                                                        const ProjectedTexture& texture);

}  // namespace meshloop
