#pragma once
// Image files: PNG (libspng), JPEG (TurboJPEG), float TIFF (libtiff). The only user of these libraries.
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

/// PNG or JPEG, told by its content; grey images become equal channels. At most 8192 pixels a side.
[[nodiscard]] Result<ColorImage> read_color_image(const std::filesystem::path& file);
/// 16-bit grey PNG, as depth images are recorded.
[[nodiscard]] Result<Image<std::uint16_t>> read_png16(const std::filesystem::path& file);
/// A depth image in the units of its file: 16-bit grey PNG or 32-bit float TIFF, told by its content.
[[nodiscard]] Result<Image<float>> read_depth_units(const std::filesystem::path& file);
/// 8-bit grey PNG (label images, masks).
[[nodiscard]] Result<GreyImage> read_png8(const std::filesystem::path& file);

[[nodiscard]] Status write_png(const std::filesystem::path& file, const ColorImage& image);
[[nodiscard]] Status write_png(const std::filesystem::path& file, const GreyImage& image);
[[nodiscard]] Status write_png(const std::filesystem::path& file, const Image<std::uint16_t>& image);
/// One 32-bit float channel; NaN is kept.
[[nodiscard]] Status write_tiff(const std::filesystem::path& file, const Image<float>& image);
[[nodiscard]] Result<Image<float>> read_tiff(const std::filesystem::path& file);

/// A PNG file's bytes, for pictures that are kept in a database or a report.
[[nodiscard]] Result<std::vector<std::byte>> encode_png(const ColorImage& image);
/// The picture of such bytes; refuses damaged ones.
[[nodiscard]] Result<ColorImage> decode_png(std::span<const std::byte> bytes);

}  // namespace meshloop
