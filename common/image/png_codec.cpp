#include "common/image/png_codec.h"

#include <fmt/format.h>
#include <spng.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string>

#include "common/image/image_file.h"
#include "common/image/image_limits.h"

namespace meshloop {
namespace {

constexpr std::size_t kLargestChunk = 16u << 20;  // text, colour profiles
constexpr std::size_t kLargestChunks = 64u << 20;

struct FreeContext {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, FreeContext>;

struct FreeBuffer {
  void operator()(void* buffer) const { std::free(buffer); }
};

tl::unexpected<Error> png_error(int code) {
  return fail(fmt::format("damaged PNG ({})", spng_strerror(code)));
}

struct Opened {
  Context context;
  spng_ihdr header{};
};

Result<Opened> open_png(std::span<const std::byte> bytes) {
  if (!is_png(bytes)) return fail("not a PNG");
  Opened png{Context{spng_ctx_new(0)}};
  if (!png.context) return fail("no memory to read a PNG");
  spng_set_image_limits(png.context.get(), kLargestSide, kLargestSide);
  spng_set_chunk_limits(png.context.get(), kLargestChunk, kLargestChunks);
  spng_set_crc_action(png.context.get(), SPNG_CRC_ERROR, SPNG_CRC_ERROR);
  if (const int code = spng_set_png_buffer(png.context.get(), bytes.data(), bytes.size())) return png_error(code);
  const int code = spng_get_ihdr(png.context.get(), &png.header);
  if (code == SPNG_EUSER_WIDTH || code == SPNG_EUSER_HEIGHT) {
    return fail(fmt::format("the picture is larger than {} pixels a side", kLargestSide));
  }
  if (code) return png_error(code);
  return png;
}

template <class T>
Result<Image<T>> decode(const Opened& png, spng_format format) {
  Image<T> image{static_cast<int>(png.header.width), static_cast<int>(png.header.height)};
  std::size_t size = 0;
  if (const int code = spng_decoded_image_size(png.context.get(), format, &size)) return png_error(code);
  if (size != image.size() * sizeof(T)) return fail("damaged PNG (its size contradicts itself)");
  if (const int code = spng_decode_image(png.context.get(), image.data(), size, format, 0)) return png_error(code);
  // Damage in the chunks behind the pixels counts too.
  if (const int code = spng_decode_chunks(png.context.get())) return png_error(code);
  return image;
}

template <class T>
Result<Image<T>> decode_grey(std::span<const std::byte> bytes, int bits) {
  auto png = open_png(bytes);
  if (!png) return fail(png.error());
  if (png->header.color_type != SPNG_COLOR_TYPE_GRAYSCALE || png->header.bit_depth != bits) {
    constexpr std::array kKinds{
        "grey", "", "colour", "palette", "grey with transparency", "", "colour with transparency"};
    return fail(fmt::format("expected a grey PNG of {} bits, but it is {} of {} bits", bits,
                            kKinds[std::min<std::size_t>(png->header.color_type, kKinds.size() - 1)],
                            png->header.bit_depth));
  }
  return decode<T>(*png, SPNG_FMT_PNG);  // 16-bit values in this machine's byte order, unlike SPNG_FMT_RAW
}

template <class T>
Result<std::vector<std::byte>> encode(const Image<T>& image, spng_color_type color_type, int bits) {
  if (image.empty()) return fail("an empty picture cannot be written");
  const Context context{spng_ctx_new(SPNG_CTX_ENCODER)};
  if (!context) return fail("no memory to write a PNG");
  spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  // A recorder has 33 ms a frame: fast compression, one cheap filter (see the README for figures).
  spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, 1);
  spng_set_option(context.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(image.width());
  header.height = static_cast<std::uint32_t>(image.height());
  header.color_type = static_cast<std::uint8_t>(color_type);
  header.bit_depth = static_cast<std::uint8_t>(bits);
  int code = spng_set_ihdr(context.get(), &header);
  if (!code) {
    code = spng_encode_image(context.get(), image.data(), image.size() * sizeof(T), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  }
  if (code) return fail(fmt::format("cannot encode a PNG ({})", spng_strerror(code)));
  std::size_t size = 0;
  const std::unique_ptr<void, FreeBuffer> buffer{spng_get_png_buffer(context.get(), &size, &code)};
  if (code || !buffer) return fail(fmt::format("cannot encode a PNG ({})", spng_strerror(code)));
  const auto* first = static_cast<const std::byte*>(buffer.get());
  return std::vector<std::byte>{first, first + size};
}

}  // namespace

bool is_png(std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  return bytes.size() >= kSignature.size() &&
         std::ranges::equal(bytes.first(kSignature.size()), std::as_bytes(std::span{kSignature}));
}

Result<ColorImage> decode_png_color(std::span<const std::byte> bytes) {
  static_assert(sizeof(Rgb8) == 3);
  auto png = open_png(bytes);
  if (!png) return fail(png.error());
  return decode<Rgb8>(*png, SPNG_FMT_RGB8);
}

Result<Image<std::uint16_t>> decode_png16(std::span<const std::byte> bytes) {
  return decode_grey<std::uint16_t>(bytes, 16);
}

Result<GreyImage> decode_png8(std::span<const std::byte> bytes) {
  return decode_grey<std::uint8_t>(bytes, 8);
}

Result<std::vector<std::byte>> encode_png(const ColorImage& image) {
  return encode(image, SPNG_COLOR_TYPE_TRUECOLOR, 8);
}
Result<std::vector<std::byte>> encode_png(const GreyImage& image) {
  return encode(image, SPNG_COLOR_TYPE_GRAYSCALE, 8);
}
Result<std::vector<std::byte>> encode_png(const Image<std::uint16_t>& image) {
  return encode(image, SPNG_COLOR_TYPE_GRAYSCALE, 16);
}

}  // namespace meshloop
