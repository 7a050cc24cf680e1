#include "server/show/overlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "server/show/blend.h"

namespace meshloop {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Rig make_rig(int width, int height) {
  Rig rig;
  rig.depth = {width, height, 0.9 * width, 0.9 * width, (width - 1) / 2.0, (height - 1) / 2.0, {}};
  rig.color = rig.depth;
  return rig;
}

Comparison make_comparison(int width, int height, Label label, float difference) {
  Comparison c;
  c.labels = Image<Label>{width, height, label};
  c.difference_m = Image<float>{width, height, difference};
  c.expected = DepthImage{width, height, 2.0f};
  c.node_index = Image<std::uint32_t>{width, height, 1};
  c.threshold_m = Image<float>{width, height, 0.005f};
  return c;
}

OverlayOptions plain() {
  OverlayOptions options;
  options.legend = false;
  return options;
}

bool is_grey(Rgb8 p) {
  return p.r == p.g && p.g == p.b;
}

template <class Picture>
std::size_t count_colored(const Picture& picture) {
  return static_cast<std::size_t>(
      std::count_if(picture.pixels().begin(), picture.pixels().end(), [](Rgb8 p) { return !is_grey(p); }));
}

TEST(OverlayOnDepth, NearIsBright) {
  auto c = make_comparison(64, 48, Label::agrees, 0);
  DepthImage measured{64, 48, 1.0f};
  for (int y = 0; y < 48; ++y) {
    for (int x = 32; x < 64; ++x) measured(x, y) = 3.0f;
  }
  measured(0, 0) = 60.0f;  // one wrong measurement does not take the contrast
  const auto picture = overlay_on_depth(c, measured, nullptr, plain());
  EXPECT_EQ(count_colored(picture), 0u);
  EXPECT_GT(picture(10, 20).r, 200);
  EXPECT_LT(picture(50, 20).r, 70);
  EXPECT_GT(picture(50, 20).r, 20);
}

TEST(OverlayOnDepth, EachLabelHasItsColorInBothPalettes) {
  for (const auto palette : {Palette::paper, Palette::color_blind_safe}) {
    for (const auto& label : kLabels) {
      auto options = plain();
      options.palette = palette;
      options.constant_alpha = 1;
      const auto c = make_comparison(32, 24, label.label, 0.5f);
      const Rgb8 p = overlay_on_depth(c, DepthImage{32, 24, 1.0f}, nullptr, options)(5, 5);
      if (label.opacity == Opacity::by_difference || label.label == Label::unmodelled) {
        EXPECT_EQ(p, show::color_of(label.label, palette)) << label.name;
      } else {
        EXPECT_EQ(is_grey(p), label.opacity == Opacity::transparent) << label.name;
      }
    }
  }
}

TEST(OverlayOnDepth, IsTheRightWayUp) {
  auto c = make_comparison(64, 48, Label::agrees, 0);
  c.labels(3, 2) = Label::closer;
  c.difference_m(3, 2) = -1;
  const auto picture = overlay_on_depth(c, DepthImage{64, 48, 1.0f}, nullptr, plain());
  EXPECT_EQ(picture(3, 2), info(Label::closer).paper_color);
  EXPECT_EQ(count_colored(picture), 1u);
}

TEST(OverlayOnDepth, AFrameWithoutAnyMeasurementIsDrawn) {
  const auto c = make_comparison(64, 48, Label::unmeasured, kNaN);
  const auto picture = overlay_on_depth(c, DepthImage{64, 48, 0.0f}, nullptr, plain());
  EXPECT_EQ(count_colored(picture), 64u * 48u);
}

TEST(Overlay, ImagesOfDifferentSizesGiveNoPicture) {
  const auto c = make_comparison(64, 48, Label::agrees, 0);
  EXPECT_TRUE(overlay_on_depth(c, DepthImage{32, 24, 1.0f}, nullptr, {}).empty());
  EXPECT_TRUE(overlay_on_depth({}, {}, nullptr, {}).empty());
}

TEST(Overlay, NarrowPicturesWithALegendAreEnlargedByAWholeNumber) {
  for (const auto& [width, height, factor] : {std::array{176, 144, 4}, {320, 240, 2}, {640, 480, 1}, {1280, 720, 1}}) {
    const auto c = make_comparison(width, height, Label::closer, -1);
    const auto picture = overlay_on_depth(c, DepthImage{width, height, 1.0f}, nullptr, {});
    EXPECT_EQ(picture.width(), width * factor);
    EXPECT_GT(picture.height(), height * factor + 40);
    EXPECT_LT(picture.height(), height * factor + 240);
    EXPECT_EQ(picture(width * factor - 1, height * factor - 1), info(Label::closer).paper_color);
  }
}

class OverlayOnColor : public testing::Test {
 protected:
  void SetUp() override {
    auto gpu = GpuContext::create_headless();
    ASSERT_TRUE(gpu) << gpu.error().message;
    gpu_ = std::move(*gpu);
    auto overlay = ColorOverlay::create(*gpu_);
    ASSERT_TRUE(overlay) << overlay.error().message;
    overlay_.emplace(std::move(*overlay));
  }
  ColorImage draw(const Comparison& comparison, const DepthImage& measured, const ColorImage& color, const Rig& rig,
                  const RegionMap* regions, const OverlayOptions& options) {
    auto picture = overlay_->draw(comparison, measured, color, rig, regions, options);
    EXPECT_TRUE(picture) << picture.error().message;
    return picture ? std::move(*picture) : ColorImage{};
  }

  std::unique_ptr<GpuContext> gpu_;
  std::optional<ColorOverlay> overlay_;
};

TEST_F(OverlayOnColor, RefusesImagesThatHaveNotTheRigsSizes) {
  const auto c = make_comparison(64, 48, Label::agrees, 0);
  const Rig rig = make_rig(64, 48);
  const auto small_color = overlay_->draw(c, DepthImage{64, 48, 1.0f}, ColorImage{32, 24}, rig, nullptr, {});
  EXPECT_THAT(small_color.error().message, testing::HasSubstr("64 x 48"));
  EXPECT_FALSE(overlay_->draw(c, DepthImage{32, 24, 1.0f}, ColorImage{64, 48}, rig, nullptr, {}));
  EXPECT_FALSE(overlay_->draw({}, DepthImage{64, 48, 1.0f}, ColorImage{64, 48}, rig, nullptr, {}));
}

TEST_F(OverlayOnColor, EachDepthPixelLandsWhereTheColorCameraSeesIt) {
  Rig rig = make_rig(320, 240);
  rig.color = {640, 480, 525, 525, 319.5, 239.5, {}};
  rig.T_depth_color =
      make_pose({0.05, -0.02, 0.01}, Eigen::Quaterniond{Eigen::AngleAxisd{0.03, Eigen::Vector3d::UnitY()}});
  auto c = make_comparison(320, 240, Label::agrees, 0);
  const DepthImage measured{320, 240, 2.0f};
  c.labels(100, 90) = Label::farther;
  c.difference_m(100, 90) = 1;
  const auto picture = draw(c, measured, ColorImage{640, 480, {90, 90, 90}}, rig, nullptr, plain());
  const auto expected = rig.color.project(rig.T_depth_color.inverse() * rig.depth.back_project(100, 90, 2.0));
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      if (is_grey(picture(x, y))) continue;
      sum += Eigen::Vector2d{x, y};
      ++count;
    }
  }
  ASSERT_GT(count, 0);
  // A depth pixel is 525 / 288 = 1.8 colour pixels wide.
  EXPECT_LE(count, 9);
  EXPECT_LT((sum / count - expected).norm(), 1.0);
}

TEST_F(OverlayOnColor, LeavesNoHolesOnASurface) {
  Rig rig = make_rig(320, 240);
  rig.color = {640, 480, 500, 500, 319.5, 239.5, {}};
  rig.T_depth_color = make_pose({0.05, 0, 0}, Eigen::Quaterniond{Eigen::AngleAxisd{0.02, Eigen::Vector3d::UnitZ()}});
  const auto c = make_comparison(320, 240, Label::closer, -1);
  DepthImage measured{320, 240};
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) measured(x, y) = 1.0f / (0.5f + 0.001f * static_cast<float>(x));  // a slanted plane
  }
  const auto picture = draw(c, measured, ColorImage{640, 480, {90, 90, 90}}, rig, nullptr, plain());
  for (int y = 80; y < 400; ++y) {
    for (int x = 150; x < 500; ++x) ASSERT_FALSE(is_grey(picture(x, y))) << x << ", " << y;
  }
}

TEST_F(OverlayOnColor, ANearSurfaceHidesWhatLiesBehind) {
  // The depth camera sees a changed wall beside a post; the colour camera, 20 cm to the right, sees the post before it.
  Rig rig = make_rig(320, 240);
  rig.T_depth_color = make_pose({0.2, 0, 0}, Eigen::Quaterniond::Identity());
  auto c = make_comparison(320, 240, Label::farther, 1);
  DepthImage measured{320, 240, 3.0f};
  for (int y = 0; y < 240; ++y) {
    for (int x = 160; x < 200; ++x) {
      measured(x, y) = 1.0f;
      c.labels(x, y) = Label::agrees;
    }
  }
  const auto picture = draw(c, measured, ColorImage{320, 240, {90, 90, 90}}, rig, nullptr, plain());
  const auto column = [&](int u, double z) {
    return static_cast<int>(
        std::lround(rig.color.project(rig.T_depth_color.inverse() * rig.depth.back_project(u, 120, z)).x()));
  };
  for (int x = column(160, 1) + 1; x < column(199, 1); ++x) EXPECT_TRUE(is_grey(picture(x, 120))) << x;
  EXPECT_FALSE(is_grey(picture(column(100, 3), 120)));
}

TEST_F(OverlayOnColor, UnmeasuredPixelsShowOnTheExpectedSurface) {
  const Rig rig = make_rig(320, 240);
  auto c = make_comparison(320, 240, Label::agrees, 0);
  DepthImage measured{320, 240, 2.0f};
  for (int y = 100; y < 140; ++y) {
    for (int x = 100; x < 140; ++x) {
      measured(x, y) = 0;
      c.labels(x, y) = Label::unmeasured;
      if (x >= 120) c.expected(x, y) = 0;  // no model either: the place is not known
    }
  }
  const auto picture = draw(c, measured, ColorImage{320, 240, {90, 90, 90}}, rig, nullptr, plain());
  EXPECT_FALSE(is_grey(picture(110, 120)));
  EXPECT_TRUE(is_grey(picture(130, 120)));
  EXPECT_TRUE(is_grey(picture(90, 120)));
}

TEST(OverlayOnDepth, FramesConfirmedRegions) {
  const auto c = make_comparison(640, 480, Label::agrees, 0);
  RegionMap regions;
  regions.ids = Image<RegionId>{640, 480};
  for (int y = 200; y < 260; ++y) {
    for (int x = 200; x < 300; ++x) regions.ids(x, y) = 3;
  }
  Region region;
  region.id = 3;
  regions.regions = {region};
  const DepthImage measured{640, 480, 2.0f};
  EXPECT_EQ(overlay_on_depth(c, measured, &regions, plain()), overlay_on_depth(c, measured, nullptr, plain()));
  regions.regions[0].confirmed = true;
  EXPECT_EQ(overlay_on_depth(c, measured, &regions, plain())(198, 230), (Rgb8{255, 255, 255}));
}

TEST_F(OverlayOnColor, FramesConfirmedRegionsOnly) {
  const Rig rig = make_rig(640, 480);
  const auto c = make_comparison(640, 480, Label::agrees, 0);
  RegionMap regions;
  regions.ids = Image<RegionId>{640, 480};
  for (int y = 200; y < 260; ++y) {
    for (int x = 200; x < 300; ++x) regions.ids(x, y) = 3;
  }
  Region region;
  region.id = 3;
  region.area_m2 = 0.0214;
  regions.regions = {region};
  const DepthImage measured{640, 480, 2.0f};
  const ColorImage color{640, 480, {90, 90, 90}};
  const auto plain_picture = draw(c, measured, color, rig, nullptr, plain());
  EXPECT_EQ(draw(c, measured, color, rig, &regions, plain()), plain_picture);
  regions.regions[0].confirmed = true;
  const auto framed = draw(c, measured, color, rig, &regions, plain());
  EXPECT_EQ(framed(198, 230), (Rgb8{255, 255, 255}));
  EXPECT_EQ(framed(250, 230), (Rgb8{90, 90, 90}));
  EXPECT_EQ(framed(400, 230), (Rgb8{90, 90, 90}));
}

TEST_F(OverlayOnColor, RegionsAtTheBordersAndManyOfThemAreDrawn) {
  const Rig rig = make_rig(64, 48);
  const auto c = make_comparison(64, 48, Label::closer, -0.1f);
  RegionMap regions;
  regions.ids = Image<RegionId>{64, 48};
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      regions.ids(x, y) = static_cast<RegionId>(1 + x / 4 + 16 * (y / 4));
    }
  }
  for (RegionId id = 1; id <= 192; ++id) {
    Region region;
    region.id = id;
    region.confirmed = true;
    regions.regions.push_back(region);
  }
  EXPECT_FALSE(draw(c, DepthImage{64, 48, 2.0f}, ColorImage{64, 48}, rig, &regions, {}).empty());
  EXPECT_FALSE(draw(c, DepthImage{64, 48, 2.0f}, ColorImage{64, 48}, rig, &regions, plain()).empty());
}

TEST_F(OverlayOnColor, IgnoresImpossibleDepths) {
  const Rig rig = make_rig(64, 48);
  const auto c = make_comparison(64, 48, Label::closer, -0.1f);
  for (const float z : {kNaN, -1.0f, std::numeric_limits<float>::infinity(), 1e-30f, 1e30f}) {
    EXPECT_FALSE(draw(c, DepthImage{64, 48, z}, ColorImage{64, 48}, rig, nullptr, plain()).empty());
    EXPECT_FALSE(overlay_on_depth(c, DepthImage{64, 48, z}, nullptr, plain()).empty());
  }
}

}  // namespace
}  // namespace meshloop
