#include "common/image/jpeg_codec.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test_images.h"

namespace meshloop {
namespace {

double rms_error(const ColorImage& a, const ColorImage& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (const auto channel : {&Rgb8::r, &Rgb8::g, &Rgb8::b}) {
      sum += std::pow(a.pixels()[i].*channel - b.pixels()[i].*channel, 2);
    }
  }
  return std::sqrt(sum / (3.0 * static_cast<double>(a.size())));
}

TEST(JpegCodec, BringsAPictureBackTheBetterTheMoreBytesItMayHave) {
  const ColorImage image = noisy_gradient(97, 61);
  std::size_t bytes = 0;
  double error = 1e9;
  for (const int quality : {30, 60, 85, 95, 100}) {
    const auto jpeg = encode_jpeg(image, quality);
    ASSERT_TRUE(jpeg) << jpeg.error().message;
    const auto decoded = decode_jpeg(*jpeg);
    ASSERT_TRUE(decoded) << decoded.error().message;
    ASSERT_EQ(decoded->width(), 97);
    ASSERT_EQ(decoded->height(), 61);
    EXPECT_GT(jpeg->size(), bytes);
    EXPECT_LT(rms_error(image, *decoded), error);
    bytes = jpeg->size();
    error = rms_error(image, *decoded);
  }
  EXPECT_LT(error, 1.5);
}

TEST(JpegCodec, KeepsHueFromPixelToPixel) {
  ColorImage stripes{32, 8};
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 32; ++x) stripes(x, y) = x % 2 == 0 ? Rgb8{200, 60, 60} : Rgb8{60, 60, 200};
  }
  EXPECT_LT(rms_error(stripes, decode_jpeg(encode_jpeg(stripes, 95).value()).value()), 6);
}

TEST(JpegCodec, TheHeaderTellsTheSizeOfAPictureThatIsCut) {
  auto jpeg = encode_jpeg(noisy_gradient(97, 61), 85).value();
  jpeg.resize(jpeg.size() / 2);
  const auto size = read_jpeg_size(jpeg);
  ASSERT_TRUE(size) << size.error().message;
  EXPECT_EQ(size->width, 97);
  EXPECT_EQ(size->height, 61);
  EXPECT_FALSE(decode_jpeg(jpeg));
  EXPECT_FALSE(read_jpeg_size(std::span{jpeg}.first(10)));
  EXPECT_FALSE(read_jpeg_size({}));
}

TEST(JpegCodec, AnEmptyPictureIsNone) {
  EXPECT_FALSE(encode_jpeg(ColorImage{}, 85));
}

}  // namespace
}  // namespace meshloop
