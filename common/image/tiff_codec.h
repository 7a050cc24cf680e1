#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

[[nodiscard]] bool is_tiff(std::span<const std::byte> bytes);
/// One channel of 32-bit float, in rows or strips.
[[nodiscard]] Result<Image<float>> decode_tiff(std::span<const std::byte> bytes);
/// Deflated; every bit pattern is kept, NaN too.
[[nodiscard]] Result<std::vector<std::byte>> encode_tiff(const Image<float>& image);

}  // namespace meshloop
