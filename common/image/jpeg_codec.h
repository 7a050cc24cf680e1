#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

[[nodiscard]] bool is_jpeg(std::span<const std::byte> bytes);

/// Of a picture, in pixels.
struct JpegSize {
  int width = 0;
  int height = 0;
};
/// What the header says, without decoding the picture. Refuses what decode_jpeg refuses by its header.
[[nodiscard]] Result<JpegSize> read_jpeg_size(std::span<const std::byte> bytes);

/// A cut or damaged JPEG is an error, although the library could fill the rest with grey.
[[nodiscard]] Result<ColorImage> decode_jpeg(std::span<const std::byte> bytes);

/// `quality`: 1 to 100, as libjpeg counts. Hue has the resolution of brightness. The image must not be empty.
[[nodiscard]] Result<std::vector<std::byte>> encode_jpeg(const ColorImage& image, int quality);

}  // namespace meshloop
