#pragma once
// A picture that is thrown onto a surface, as a slide projector would.
#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

/// 3x4: from points to pixels.
using TextureProjection = Eigen::Matrix<float, 3, 4>;

/// Colours of a surface, by where its points lie in a picture. There are no coordinates per vertex: whatever is cut,
/// left out, divided or moved with its node keeps its colours.
struct ProjectedTexture {
  /// What is hashed, stored and sent, byte for byte.
  std::vector<std::byte> jpeg;
  /// Of the picture, in pixels: what the JPEG's header says.
  int width = 0;
  int height = 0;
  /// A point p (metres, in the node's frame) has h = projection * (p, 1) and the pixel (h.x / h.z, h.y / h.z). As in
  /// Camera, (0, 0) is the middle of the first pixel, which reaches from -0.5 to 0.5. h.z is above 0.
  TextureProjection projection = TextureProjection::Zero();
};

/// What every GLES 3.1 device can hold.
inline constexpr int kLargestTextureSide = 2048;
/// Of the JPEG. A node is sent as one message of at most 1 MiB; the rest is for its triangles.
inline constexpr std::size_t kMostTextureBytes = 768u << 10;

/// A texture with the size that the JPEG's header says. Refuses what `validate` refuses.
[[nodiscard]] Result<std::shared_ptr<const ProjectedTexture>> make_projected_texture(
    std::vector<std::byte> jpeg, const TextureProjection& projection);

/// Refuses a picture that is no JPEG, too large, or of another size than stated, a projection that is not finite, and
/// points that it does not see: behind it, or nowhere in its plane. Looks at the JPEG's header alone.
[[nodiscard]] Status validate(const ProjectedTexture& texture, std::span<const Eigen::Vector3f> positions);

/// Where a point lies in the picture. Its h.z must be above 0.
[[nodiscard]] Eigen::Vector2f pixel_of(const ProjectedTexture& texture, const Eigen::Vector3f& p);

/// Between the four nearest pixels, in their bytes; beyond the picture its border goes on. As the GPU samples.
[[nodiscard]] Rgb8 bilinear(const ColorImage& picture, const Eigen::Vector2f& pixel);

}  // namespace meshloop
