#include "server/show/thumbnail.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>
#include <vector>

namespace meshloop {
namespace {

// Depth and colour of one size, pixel by pixel, of a wall with a square region.
class Thumbnail : public testing::Test {
 protected:
  Thumbnail() {
    std::iota(source_.pixels().begin(), source_.pixels().end(), 1U);
    comparison_ = {Image<Label>(160, 120, Label::agrees), Image<float>(160, 120, 0.0F), DepthImage(160, 120, 2.0F),
                   Image<std::uint32_t>(160, 120, 1U), Image<float>(160, 120, 0.02F)};
    regions_.ids = Image<RegionId>(160, 120);
  }
  void paint(RegionId id, int left, int top, int width, int height, Label label) {
    for (int v = top; v < top + height; ++v) {
      for (int u = left; u < left + width; ++u) {
        comparison_.labels(u, v) = label;
        regions_.ids(u, v) = id;
      }
    }
    Region region;
    region.id = id;
    region.pixels = width * height;
    regions_.regions.push_back(region);
  }
  std::vector<RegionThumbnail> thumbnails(const std::vector<RegionId>& wanted) const {
    return region_thumbnails(source_, comparison_, color_, regions_, wanted, Palette::paper);
  }

  Image<std::uint32_t> source_{160, 120};
  Comparison comparison_;
  RegionMap regions_;
  ColorImage color_{160, 120, Rgb8{40, 50, 60}};
};

bool is_near(Rgb8 a, Rgb8 b, int tolerance) {
  return std::abs(a.r - b.r) <= tolerance && std::abs(a.g - b.g) <= tolerance && std::abs(a.b - b.b) <= tolerance;
}

TEST_F(Thumbnail, ShowsTheRegionWithItsSurroundingsAndOutline) {
  paint(3, 60, 40, 40, 20, Label::closer);
  for (int v = 40; v < 60; ++v) {
    for (int u = 60; u < 100; ++u) color_(u, v) = {200, 200, 100};
  }
  const auto made = thumbnails({3});
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].id, 3U);
  const ColorImage& picture = made[0].picture;
  EXPECT_EQ(picture.width(), kThumbnail_px);
  EXPECT_LT(picture.height(), kThumbnail_px);
  EXPECT_TRUE(is_near(picture(picture.width() / 2, picture.height() / 2), {200, 200, 100}, 3));
  EXPECT_TRUE(is_near(picture(2, 2), {40, 50, 60}, 3));
  std::size_t red = 0;
  for (const Rgb8 pixel : picture.pixels()) red += is_near(pixel, info(Label::closer).paper_color, 30) ? 1 : 0;
  EXPECT_GT(red, 200U);
}

TEST_F(Thumbnail, OnlyWhatIsWantedAndSeenIsDrawn) {
  paint(1, 10, 10, 20, 20, Label::closer);
  paint(2, 100, 60, 20, 20, Label::farther);
  const auto made = thumbnails({2, 7});
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].id, 2U);
  EXPECT_TRUE(thumbnails({}).empty());
}

TEST_F(Thumbnail, RegionAtTheBorderIsCutThere) {
  paint(1, 0, 0, 10, 120, Label::unmodelled);
  const auto made = thumbnails({1});
  ASSERT_EQ(made.size(), 1U);
  EXPECT_EQ(made[0].picture.height(), kThumbnail_px);
}

TEST_F(Thumbnail, ImagesOfOtherSizesGiveNone) {
  paint(1, 10, 10, 20, 20, Label::closer);
  color_ = ColorImage(80, 60);
  EXPECT_TRUE(thumbnails({1}).empty());
}

}  // namespace
}  // namespace meshloop
