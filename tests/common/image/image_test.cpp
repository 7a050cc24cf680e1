#include "common/image/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace meshloop {
namespace {

TEST(Image, RowsFollowEachOtherFromTheTop) {
  Image<int> image{3, 2, 7};
  image(2, 1) = 1;
  EXPECT_EQ(image.size(), 6u);
  EXPECT_EQ(image.pixels()[5], 1);
  EXPECT_EQ(image.pixels()[4], 7);
  EXPECT_EQ(&image.view()(0, 1), image.data() + 3);
}

TEST(Image, ImagesAreEqualWhenSizesAndPixelsAre) {
  EXPECT_EQ((Image<int>{3, 2}), (Image<int>{3, 2}));
  EXPECT_NE((Image<int>{3, 2}), (Image<int>{2, 3}));
  EXPECT_TRUE(Image<int>{}.empty());
  EXPECT_TRUE((Image<int>{0, 5}).empty());
}

TEST(Image, GreyIsTheRoundedLumaForEveryCube) {
  for (int r = 0; r < 256; r += 15) {
    for (int g = 0; g < 256; g += 15) {
      for (int b = 0; b < 256; b += 15) {
        const Rgb8 color{static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)};
        const int grey = to_grey(ColorImage{1, 1, color})(0, 0);
        EXPECT_LE(std::abs(grey - (0.299 * r + 0.587 * g + 0.114 * b)), 0.505);
      }
    }
  }
}

TEST(Image, GreySurvivesTheWayThroughColor) {
  GreyImage grey{256, 1};
  for (int i = 0; i < 256; ++i) grey(i, 0) = static_cast<std::uint8_t>(i);
  EXPECT_EQ(to_grey(to_color(grey)), grey);
}

}  // namespace
}  // namespace meshloop
