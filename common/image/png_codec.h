#pragma once
// PNG bytes to pixels and back. Private to this room.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

[[nodiscard]] bool is_png(std::span<const std::byte> bytes);
/// Any PNG; transparency is left out, deeper channels are cut to 8 bits.
[[nodiscard]] Result<ColorImage> decode_png_color(std::span<const std::byte> bytes);
/// Only a grey PNG of 16 (8) bits.
[[nodiscard]] Result<Image<std::uint16_t>> decode_png16(std::span<const std::byte> bytes);
[[nodiscard]] Result<GreyImage> decode_png8(std::span<const std::byte> bytes);

[[nodiscard]] Result<std::vector<std::byte>> encode_png(const GreyImage& image);
[[nodiscard]] Result<std::vector<std::byte>> encode_png(const Image<std::uint16_t>& image);

}  // namespace meshloop
