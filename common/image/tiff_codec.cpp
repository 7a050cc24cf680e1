#include "common/image/tiff_codec.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>

#include "common/image/image_limits.h"

namespace meshloop {
namespace {

/// A file in memory, as libtiff sees it.
struct Memory {
  std::vector<std::byte> bytes;
  std::size_t position = 0;
  std::string problem;
};

Memory& memory(thandle_t handle) {
  return *static_cast<Memory*>(handle);
}

tmsize_t read_some(thandle_t handle, void* to, tmsize_t size) {
  auto& file = memory(handle);
  const auto left = file.bytes.size() - std::min(file.position, file.bytes.size());
  const auto count = std::min(static_cast<std::size_t>(size), left);
  if (count > 0) std::memcpy(to, file.bytes.data() + file.position, count);
  file.position += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t write_some(thandle_t handle, void* from, tmsize_t size) {
  auto& file = memory(handle);
  const auto count = static_cast<std::size_t>(size);
  if (file.bytes.size() < file.position + count) file.bytes.resize(file.position + count);
  if (count > 0) std::memcpy(file.bytes.data() + file.position, from, count);
  file.position += count;
  return size;
}

toff_t seek(thandle_t handle, toff_t offset, int whence) {
  auto& file = memory(handle);
  const toff_t base = whence == SEEK_CUR ? file.position : whence == SEEK_END ? file.bytes.size() : 0;
  // Reading beyond the end gives nothing; writing far beyond it is no case of ours.
  file.position = static_cast<std::size_t>(std::min<toff_t>(base + offset, kLargestImageFile));
  return file.position;
}

int keep_open(thandle_t) {
  return 0;
}
toff_t size_of(thandle_t handle) {
  return memory(handle).bytes.size();
}

int note_problem(TIFF*, void* user, const char*, const char* format, va_list args) {
  std::array<char, 256> text{};
  std::vsnprintf(text.data(), text.size(), format, args);
  auto& file = *static_cast<Memory*>(user);
  if (file.problem.empty()) file.problem = text.data();
  return 1;
}

int ignore_warning(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}

struct Close {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using Tiff = std::unique_ptr<TIFF, Close>;

Tiff open_tiff(Memory& file, const char* mode) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  if (!options) return {};
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, static_cast<tmsize_t>(kLargestImageFile));
  TIFFOpenOptionsSetErrorHandlerExtR(options, note_problem, &file);
  TIFFOpenOptionsSetWarningHandlerExtR(options, ignore_warning, nullptr);
  Tiff tiff{TIFFClientOpenExt("TIFF", mode, &file, read_some, write_some, seek, keep_open, size_of, nullptr, nullptr,
                              options)};
  TIFFOpenOptionsFree(options);
  return tiff;
}

Status check_layout(TIFF* tiff) {
  std::uint16_t channels = 0;
  std::uint16_t bits = 0;
  std::uint16_t format = 0;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
  if (channels != 1 || bits != 32 || format != SAMPLEFORMAT_IEEEFP || TIFFIsTiled(tiff)) {
    return fail("expected a TIFF with one channel of 32-bit float, in strips");
  }
  return {};
}

}  // namespace

bool is_tiff(std::span<const std::byte> bytes) {
  if (bytes.size() < 4) return false;
  const auto is = [&](std::string_view first) { return std::memcmp(bytes.data(), first.data(), first.size()) == 0; };
  return is({"II*\0", 4}) || is({"MM\0*", 4}) || is({"II+\0", 4}) || is({"MM\0+", 4});
}

Result<Image<float>> decode_tiff(std::span<const std::byte> bytes) {
  Memory file{{bytes.begin(), bytes.end()}, 0, {}};
  const Tiff tiff = open_tiff(file, "rm");
  const auto damaged = [&] { return fail(fmt::format("damaged TIFF ({})", file.problem)); };
  if (!tiff) return fail("not a TIFF");
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
  if (width < 1 || height < 1) return fail("damaged TIFF (it has no pixels)");
  if (std::max(width, height) > static_cast<std::uint32_t>(kLargestSide)) {
    return fail(fmt::format("the picture is larger than {} pixels a side", kLargestSide));
  }
  if (auto ok = check_layout(tiff.get()); !ok) return fail(ok.error());
  Image<float> image{static_cast<int>(width), static_cast<int>(height)};
  if (TIFFScanlineSize(tiff.get()) != static_cast<tmsize_t>(width * sizeof(float))) return damaged();
  for (std::uint32_t y = 0; y < height; ++y) {
    if (TIFFReadScanline(tiff.get(), &image(0, static_cast<int>(y)), y, 0) != 1) return damaged();
  }
  return image;
}

Result<std::vector<std::byte>> encode_tiff(const Image<float>& image) {
  if (image.empty()) return fail("an empty picture cannot be written");
  Memory file;
  Tiff tiff = open_tiff(file, "w");
  if (!tiff) return fail(fmt::format("cannot encode a TIFF ({})", file.problem));
  TIFFSetField(tiff.get(), TIFFTAG_IMAGEWIDTH, image.width());
  TIFFSetField(tiff.get(), TIFFTAG_IMAGELENGTH, image.height());
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff.get(), TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff.get(), TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff.get(), TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff.get(), TIFFTAG_ZIPQUALITY, 1);
  TIFFSetField(tiff.get(), TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(tiff.get(), 0));
  std::vector<float> row(static_cast<std::size_t>(image.width()));
  for (int y = 0; y < image.height(); ++y) {
    std::copy_n(&image(0, y), row.size(), row.begin());  // libtiff may reorder the bytes it is given
    if (TIFFWriteScanline(tiff.get(), row.data(), static_cast<std::uint32_t>(y), 0) != 1) {
      return fail(fmt::format("cannot encode a TIFF ({})", file.problem));
    }
  }
  if (TIFFFlush(tiff.get()) != 1) return fail(fmt::format("cannot encode a TIFF ({})", file.problem));
  tiff.reset();
  return std::move(file.bytes);
}

}  // namespace meshloop
