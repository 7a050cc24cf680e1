#include "common/image/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <bit>
#include <cmath>
#include <limits>

#include "common/base/file.h"
#include "common/image/jpeg_codec.h"
#include "temporary_folder.h"
#include "test_images.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

std::vector<std::byte> bytes_of(const std::filesystem::path& file) {
  return read_file(file, 1u << 28).value();
}

TEST(ImageFile, ColorPngComesBackUnchanged) {
  const TemporaryFolder folder;
  const ColorImage image = noisy_gradient(67, 43);
  ASSERT_TRUE(write_png(folder / "a.png", image));
  EXPECT_EQ(read_color_image(folder / "a.png").value(), image);
  EXPECT_EQ(bytes_of(folder / "a.png"), encode_png(image).value());
}

TEST(ImageFile, SixteenBitPngKeepsEveryValueAndStoresBigEndian) {
  const TemporaryFolder folder;
  Image<std::uint16_t> image{256, 256};
  for (std::size_t i = 0; i < image.size(); ++i) image.pixels()[i] = static_cast<std::uint16_t>(i);
  ASSERT_TRUE(write_png(folder / "a.png", image));
  EXPECT_EQ(read_png16(folder / "a.png").value(), image);
  const auto units = read_depth_units(folder / "a.png").value();
  for (std::size_t i = 0; i < image.size(); ++i) EXPECT_EQ(units.pixels()[i], image.pixels()[i]);
  // Read as 8 bits a reader sees the high byte, so its place in the file is right.
  EXPECT_EQ(read_color_image(folder / "a.png").value()(0, 0x12).r, 0x12);
}

TEST(ImageFile, GreyPngComesBackAndReadsAsEqualChannels) {
  const TemporaryFolder folder;
  GreyImage image{31, 17, 9};
  image(30, 16) = 200;
  ASSERT_TRUE(write_png(folder / "a.png", image));
  EXPECT_EQ(read_png8(folder / "a.png").value(), image);
  EXPECT_EQ(read_color_image(folder / "a.png").value(), to_color(image));
}

TEST(ImageFile, TiffKeepsEveryBitAlsoOfNaN) {
  const TemporaryFolder folder;
  Image<float> image{641, 33, 0.1f};
  image(0, 0) = std::numeric_limits<float>::quiet_NaN();
  image(640, 32) = -std::numeric_limits<float>::infinity();
  image(5, 5) = std::numeric_limits<float>::denorm_min();
  ASSERT_TRUE(write_tiff(folder / "a.tiff", image));
  const auto read = read_tiff(folder / "a.tiff").value();
  ASSERT_EQ(read.width(), 641);
  for (std::size_t i = 0; i < image.size(); ++i) {
    ASSERT_EQ(std::bit_cast<std::uint32_t>(read.pixels()[i]), std::bit_cast<std::uint32_t>(image.pixels()[i]));
  }
}

TEST(ImageFile, WrongKindOfPngNamesBothKinds) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_png(folder / "color.png", noisy_gradient(20, 20)));
  ASSERT_TRUE(write_png(folder / "grey.png", GreyImage{20, 20}));
  EXPECT_THAT(read_png16(folder / "color.png").error().message,
              HasSubstr("expected a grey PNG of 16 bits, but it is colour of 8 bits"));
  EXPECT_THAT(read_png16(folder / "grey.png").error().message, HasSubstr("grey of 8 bits"));
  EXPECT_THAT(read_png8(folder / "color.png").error().message, HasSubstr("colour of 8 bits"));
  EXPECT_THAT(read_tiff(folder / "grey.png").error().message, HasSubstr("not a TIFF"));
}

TEST(ImageFile, MissingForeignAndEmptyFilesNameTheFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_text_file(folder / "text", "hello"));
  ASSERT_TRUE(write_text_file(folder / "empty", ""));
  EXPECT_THAT(read_color_image(folder / "none").error().message, HasSubstr("none"));
  EXPECT_THAT(read_color_image(folder / "text").error().message, HasSubstr("neither PNG nor JPEG"));
  EXPECT_THAT(read_color_image(folder / "empty").error().message, HasSubstr("empty': neither"));
  EXPECT_THAT(read_png16(folder / "text").error().message, HasSubstr("not a PNG"));
  EXPECT_THAT(read_color_image(folder.path()).error().message, HasSubstr("not a file"));
}

TEST(ImageFile, UnwritableTargetsAndEmptyImagesAreErrors) {
  const TemporaryFolder folder;
  const ColorImage image{16, 16};
  EXPECT_THAT(write_png("/dev/full", image).error().message, HasSubstr("No space left"));
  EXPECT_THAT(write_tiff("/dev/full", Image<float>{16, 16}).error().message, HasSubstr("No space left"));
  EXPECT_FALSE(write_png(folder / "none/a.png", image));
  EXPECT_THAT(write_png(folder / "a.png", ColorImage{}).error().message, HasSubstr("empty picture"));
  EXPECT_FALSE(write_tiff(folder / "a.tiff", Image<float>{}));
}

std::vector<std::byte> jpeg_of(const ColorImage& image) {
  tjhandle handle = tjInitCompress();
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, reinterpret_cast<const unsigned char*>(image.data()), image.width(), 0, image.height(), TJPF_RGB,
              &buffer, &size, TJSAMP_444, 95, 0);
  const auto* first = reinterpret_cast<const std::byte*>(buffer);
  std::vector<std::byte> bytes{first, first + size};
  tjFree(buffer);
  tjDestroy(handle);
  return bytes;
}

TEST(ImageFile, ReadsJpegWithinItsLoss) {
  ColorImage image{64, 48, {200, 100, 50}};
  const auto read = decode_jpeg(jpeg_of(image));
  ASSERT_TRUE(read);
  for (const Rgb8 pixel : read->pixels()) {
    EXPECT_NEAR(pixel.r, 200, 4);
    EXPECT_NEAR(pixel.g, 100, 4);
    EXPECT_NEAR(pixel.b, 50, 4);
  }
}

TEST(ImageFile, ACutJpegIsAnErrorAndNotHalfGrey) {
  const auto bytes = jpeg_of(noisy_gradient(64, 48));
  for (std::size_t size = 3; size < bytes.size() - 2; size += 7) {
    EXPECT_FALSE(decode_jpeg(std::span{bytes}.first(size))) << size;
  }
}

}  // namespace
}  // namespace meshloop
