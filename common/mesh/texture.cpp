#include "common/mesh/texture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/image/jpeg_codec.h"

namespace meshloop {
namespace {

Eigen::Vector3f homogeneous(const TextureProjection& projection, const Eigen::Vector3f& p) {
  return projection.leftCols<3>() * p + projection.col(3);
}

bool is_seen(const TextureProjection& projection, const Eigen::Vector3f& p) {
  const Eigen::Vector3f h = homogeneous(projection, p);
  return h.z() > 0 && std::isfinite(h.x() / h.z()) && std::isfinite(h.y() / h.z());
}

Status check_picture(std::span<const std::byte> jpeg, const JpegSize& stated) {
  if (jpeg.size() > kMostTextureBytes) {
    return fail(
        fmt::format("the texture has {} bytes; at most {} can be sent with a node: make it smaller, or its "
                    "quality lower",
                    jpeg.size(), kMostTextureBytes));
  }
  const auto size = read_jpeg_size(jpeg);
  if (!size) return fail("the texture", size.error());
  if (std::max(size->width, size->height) > kLargestTextureSide) {
    return fail(fmt::format("the texture has {} x {} pixels; at most {} a side are accepted", size->width, size->height,
                            kLargestTextureSide));
  }
  if (size->width != stated.width || size->height != stated.height) {
    return fail(fmt::format("the texture has {} x {} pixels, not {} x {}", size->width, size->height, stated.width,
                            stated.height));
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<const ProjectedTexture>> make_projected_texture(std::vector<std::byte> jpeg,
                                                                       const TextureProjection& projection) {
  const auto size = read_jpeg_size(jpeg);
  if (!size) return fail("the texture", size.error());
  auto texture = std::make_shared<ProjectedTexture>();
  texture->jpeg = std::move(jpeg);
  texture->width = size->width;
  texture->height = size->height;
  texture->projection = projection;
  if (auto ok = validate(*texture, {}); !ok) return fail(ok.error());
  return std::shared_ptr<const ProjectedTexture>{std::move(texture)};
}

Status validate(const ProjectedTexture& texture, std::span<const Eigen::Vector3f> positions) {
  if (auto ok = check_picture(texture.jpeg, {texture.width, texture.height}); !ok) return ok;
  if (!texture.projection.allFinite()) return fail("the texture's projection has a value that is no finite number");
  if (!std::all_of(positions.begin(), positions.end(),
                   [&](const Eigen::Vector3f& p) { return is_seen(texture.projection, p); })) {
    return fail("a vertex lies behind the camera that took the texture");
  }
  return {};
}

Eigen::Vector2f pixel_of(const ProjectedTexture& texture, const Eigen::Vector3f& p) {
  const Eigen::Vector3f h = homogeneous(texture.projection, p);
  return h.head<2>() / h.z();
}

Rgb8 bilinear(const ColorImage& picture, const Eigen::Vector2f& pixel) {
  const float x = std::clamp(pixel.x(), 0.0f, static_cast<float>(picture.width() - 1));
  const float y = std::clamp(pixel.y(), 0.0f, static_cast<float>(picture.height() - 1));
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, picture.width() - 1);
  const int y1 = std::min(y0 + 1, picture.height() - 1);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const auto mix = [&](std::uint8_t Rgb8::*channel) {
    const auto at = [&](int u, int v) { return static_cast<float>(picture(u, v).*channel); };
    const float top = at(x0, y0) + (at(x1, y0) - at(x0, y0)) * fx;
    const float bottom = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * fx;
    return static_cast<std::uint8_t>(std::lround(top + (bottom - top) * fy));
  };
  return {mix(&Rgb8::r), mix(&Rgb8::g), mix(&Rgb8::b)};
}

}  // namespace meshloop
