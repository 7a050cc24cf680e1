#include "common/image/image_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "common/base/file.h"
#include "common/image/image_limits.h"
#include "common/image/jpeg_codec.h"
#include "common/image/png_codec.h"
#include "common/image/tiff_codec.h"

namespace meshloop {
namespace {

Result<ColorImage> decode_color(std::span<const std::byte> bytes) {
  if (is_png(bytes)) return decode_png_color(bytes);
  if (is_jpeg(bytes)) return decode_jpeg(bytes);
  return fail("neither PNG nor JPEG");
}

Result<Image<float>> decode_depth(std::span<const std::byte> bytes) {
  if (is_tiff(bytes)) return decode_tiff(bytes);
  if (!is_png(bytes)) return fail("neither 16-bit PNG nor float TIFF");
  const auto whole = decode_png16(bytes);
  if (!whole) return fail(whole.error());
  Image<float> units{whole->width(), whole->height()};
  std::copy(whole->pixels().begin(), whole->pixels().end(), units.pixels().begin());
  return units;
}

template <class T>
Result<Image<T>> read_image(const std::filesystem::path& file, Result<Image<T>> (*decode)(std::span<const std::byte>)) {
  const auto bytes = read_file(file, kLargestImageFile);
  if (!bytes) return fail(bytes.error());
  auto image = decode(*bytes);
  if (!image) return fail(fmt::format("cannot read '{}'", file.string()), image.error());
  return image;
}

Status write_image(const std::filesystem::path& file, const Result<std::vector<std::byte>>& bytes) {
  if (!bytes) return fail(fmt::format("cannot write '{}'", file.string()), bytes.error());
  return write_file(file, *bytes);
}

}  // namespace

Result<ColorImage> read_color_image(const std::filesystem::path& file) {
  return read_image(file, decode_color);
}

Result<Image<std::uint16_t>> read_png16(const std::filesystem::path& file) {
  return read_image(file, decode_png16);
}

Result<Image<float>> read_depth_units(const std::filesystem::path& file) {
  return read_image(file, decode_depth);
}

Result<GreyImage> read_png8(const std::filesystem::path& file) {
  return read_image(file, decode_png8);
}

Result<Image<float>> read_tiff(const std::filesystem::path& file) {
  return read_image(file, decode_tiff);
}

Result<ColorImage> decode_png(std::span<const std::byte> bytes) {
  if (!is_png(bytes)) return fail("not a PNG");
  return decode_png_color(bytes);
}

Status write_png(const std::filesystem::path& file, const ColorImage& image) {
  return write_image(file, encode_png(image));
}
Status write_png(const std::filesystem::path& file, const GreyImage& image) {
  return write_image(file, encode_png(image));
}
Status write_png(const std::filesystem::path& file, const Image<std::uint16_t>& image) {
  return write_image(file, encode_png(image));
}
Status write_tiff(const std::filesystem::path& file, const Image<float>& image) {
  return write_image(file, encode_tiff(image));
}

}  // namespace meshloop
