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

tl::unexpected<Error> jpeg_error(tjhandle handle) {
  return fail(fmt::format("damaged JPEG ({})", tjGetErrorStr2(handle)));
}

}  // namespace

bool is_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0xff} && bytes[1] == std::byte{0xd8} && bytes[2] == std::byte{0xff};
}

Result<ColorImage> decode_jpeg(std::span<const std::byte> bytes) {
  const std::unique_ptr<void, Destroy> handle{tjInitDecompress()};
  if (!handle) return fail("no memory to read a JPEG");
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int color_space = 0;
  if (tjDecompressHeader3(handle.get(), data, bytes.size(), &width, &height, &subsampling, &color_space) != 0) {
    return jpeg_error(handle.get());
  }
  if (width < 1 || height < 1) return fail("damaged JPEG (it has no pixels)");
  if (std::max(width, height) > kLargestSide) {
    return fail(fmt::format("the picture is larger than {} pixels a side", kLargestSide));
  }
  if (color_space == TJCS_CMYK || color_space == TJCS_YCCK) {
    return fail("a CMYK JPEG; save the picture as RGB");
  }
  ColorImage image{width, height};
  // Warnings count: a truncated file is one. The limit on scans stops small files that take hours.
  constexpr int kFlags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  auto* pixels = reinterpret_cast<unsigned char*>(image.data());
  if (tjDecompress2(handle.get(), data, bytes.size(), pixels, width, 0, height, TJPF_RGB, kFlags) != 0) {
    return jpeg_error(handle.get());
  }
  return image;
}

}  // namespace meshloop
