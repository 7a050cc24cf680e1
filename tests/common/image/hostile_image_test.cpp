#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "common/image/image_file.h"
#include "common/image/png_codec.h"
#include "common/image/tiff_codec.h"
#include "test_images.h"

namespace meshloop {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

void append32(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::byte>(value >> shift));
}

std::uint32_t crc32(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const auto byte : bytes) {
    crc ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) ? 0xedb88320u : 0u);
  }
  return ~crc;
}

// A PNG that claims a size and holds no pixels.
Bytes png_that_claims(std::uint32_t width, std::uint32_t height) {
  Bytes bytes;
  for (const int b : {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a}) bytes.push_back(static_cast<std::byte>(b));
  append32(bytes, 13);
  const auto start = bytes.size();
  for (const char c : {'I', 'H', 'D', 'R'}) bytes.push_back(static_cast<std::byte>(c));
  append32(bytes, width);
  append32(bytes, height);
  for (const int b : {8, 2, 0, 0, 0}) bytes.push_back(static_cast<std::byte>(b));
  append32(bytes, crc32(std::span{bytes}.subspan(start)));
  return bytes;
}

// Behind the pixels stand 12 bytes that end the file; without them the picture is still whole.
TEST(HostileImage, ACutPngIsAnErrorAndNeverHalfAPicture) {
  const ColorImage image = noisy_gradient(23, 19);
  const Bytes bytes = encode_png(image).value();
  ASSERT_TRUE(decode_png_color(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = decode_png_color(std::span{bytes}.first(size));
    EXPECT_TRUE(!cut || (size >= bytes.size() - 12 && *cut == image)) << size << " of " << bytes.size();
  }
}

TEST(HostileImage, EveryFlippedByteOfAPngIsAnError) {
  const Bytes bytes = encode_png(noisy_gradient(23, 19)).value();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    Bytes damaged = bytes;
    damaged[i] ^= std::byte{0x5a};
    EXPECT_FALSE(decode_png_color(damaged)) << i << " of " << bytes.size();
  }
}

TEST(HostileImage, APngThatClaimsTooManyPixelsIsRefusedBeforeMemoryIsTaken) {
  EXPECT_THAT(decode_png_color(png_that_claims(8193, 10)).error().message, HasSubstr("larger than 8192"));
  EXPECT_THAT(decode_png_color(png_that_claims(10, 0x7fffffff)).error().message, HasSubstr("larger than 8192"));
  EXPECT_FALSE(decode_png_color(png_that_claims(0, 10)));
  EXPECT_FALSE(decode_png_color(png_that_claims(64, 64)));
}

// The last 4 bytes say that no second picture follows.
TEST(HostileImage, ACutTiffIsAnErrorAndNeverHalfAPicture) {
  Image<float> image{37, 29};
  for (std::size_t i = 0; i < image.size(); ++i) image.pixels()[i] = static_cast<float>(i * i % 97) * 0.37f;
  const Bytes bytes = encode_tiff(image).value();
  ASSERT_EQ(decode_tiff(bytes).value(), image);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = decode_tiff(std::span{bytes}.first(size));
    EXPECT_TRUE(!cut || (size >= bytes.size() - 4 && *cut == image)) << size << " of " << bytes.size();
  }
}

TEST(HostileImage, DamagedTiffsNeverCrashAndKeepTheSizeLimit) {
  const Bytes bytes = encode_tiff(Image<float>{37, 29, 1.5f}).value();
  std::mt19937 random{11};
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    Bytes damaged = bytes;
    for (int i = 0; i < 3; ++i) damaged[random() % damaged.size()] = static_cast<std::byte>(random());
    const auto image = decode_tiff(damaged);
    if (image) {
      EXPECT_LE(std::max(image->width(), image->height()), 8192);
    }
    refused += image ? 0 : 1;
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace meshloop
