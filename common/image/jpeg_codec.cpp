#include "common/image/jpeg_codec.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <algorithm>
#include <memory>

#include "common/image/image_limits.h"

namespace meshloop {
namespace {

struct Destroy {
  void operator()(void* handle) const { tjDestroy(handle); }
};

struct Free {
  void operator()(unsigned char* bytes) const { tjFree(bytes); }
};

tl::unexpected<Error> jpeg_error(tjhandle handle) {
  return fail(fmt::format("damaged JPEG ({})", tjGetErrorStr2(handle)));
}

const unsigned char* data_of(std::span<const std::byte> bytes) {
  return reinterpret_cast<const unsigned char*>(bytes.data());
}

Result<JpegSize> size_of(tjhandle handle, std::span<const std::byte> bytes) {
  JpegSize size;
  int subsampling = 0;
  int color_space = 0;
  if (tjDecompressHeader3(handle, data_of(bytes), bytes.size(), &size.width, &size.height, &subsampling,
                          &color_space) != 0) {
    return jpeg_error(handle);
  }
  if (size.width < 1 || size.height < 1) return fail("damaged JPEG (it has no pixels)");
  if (std::max(size.width, size.height) > kLargestSide) {
    return fail(fmt::format("the picture is larger than {} pixels a side", kLargestSide));
  }
  if (color_space == TJCS_CMYK || color_space == TJCS_YCCK) {
    return fail("a CMYK JPEG; save the picture as RGB");
  }
  return size;
}

}  // namespace

bool is_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0xff} && bytes[1] == std::byte{0xd8} && bytes[2] == std::byte{0xff};
}

Result<JpegSize> read_jpeg_size(std::span<const std::byte> bytes) {
  const std::unique_ptr<void, Destroy> handle{tjInitDecompress()};
  if (!handle) return fail("no memory to read a JPEG");
  return size_of(handle.get(), bytes);
}

Result<ColorImage> decode_jpeg(std::span<const std::byte> bytes) {
  const std::unique_ptr<void, Destroy> handle{tjInitDecompress()};
  if (!handle) return fail("no memory to read a JPEG");
  const auto size = size_of(handle.get(), bytes);
  if (!size) return fail(size.error());
  ColorImage image{size->width, size->height};
  // Warnings count: a truncated file is one. The limit on scans stops small files that take hours.
  constexpr int kFlags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  auto* pixels = reinterpret_cast<unsigned char*>(image.data());
  if (tjDecompress2(handle.get(), data_of(bytes), bytes.size(), pixels, size->width, 0, size->height, TJPF_RGB,
                    kFlags) != 0) {
    return jpeg_error(handle.get());
  }
  return image;
}

Result<std::vector<std::byte>> encode_jpeg(const ColorImage& image, int quality) {
  const std::unique_ptr<void, Destroy> handle{tjInitCompress()};
  if (!handle) return fail("no memory to write a JPEG");
  unsigned char* encoded = nullptr;
  unsigned long size = 0;
  const int error =
      tjCompress2(handle.get(), reinterpret_cast<const unsigned char*>(image.data()), image.width(), 0, image.height(),
                  TJPF_RGB, &encoded, &size, TJSAMP_444, quality, TJFLAG_ACCURATEDCT | TJFLAG_PROGRESSIVE);
  const std::unique_ptr<unsigned char, Free> owner{encoded};
  if (error != 0) return fail(fmt::format("a JPEG cannot be written ({})", tjGetErrorStr2(handle.get())));
  const auto bytes = std::as_bytes(std::span{encoded, size});
  return std::vector<std::byte>{bytes.begin(), bytes.end()};
}

}  // namespace meshloop
