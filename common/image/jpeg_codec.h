#pragma once
#include <cstddef>
#include <span>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

[[nodiscard]] bool is_jpeg(std::span<const std::byte> bytes);
/// A cut or damaged JPEG is an error, although the library could fill the rest with grey.
[[nodiscard]] Result<ColorImage> decode_jpeg(std::span<const std::byte> bytes);

}  // namespace meshloop
