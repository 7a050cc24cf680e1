#include "server/show/legend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "server/show/blend.h"

namespace meshloop {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TEST(Paint, OpacityGrowsWithTheDifferenceUntilSolid) {
  OverlayOptions options;
  options.opacity_per_m = 25;
  const show::Paint paint{options};
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::closer, -0.01f), 0.25f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::farther, 0.02f), 0.5f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::farther, 0.04f), 1.0f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::farther, 3.0f), 1.0f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::closer, kNaN), 1.0f);
}

TEST(Paint, LabelsWithoutADifferenceHaveAConstantOpacity) {
  OverlayOptions options;
  options.constant_alpha = 0.4;
  const show::Paint paint{options};
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::unmodelled, kNaN), 0.4f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::unmeasured, kNaN), 0.2f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::agrees, 0.004f), 0.0f);
  EXPECT_FLOAT_EQ(paint.alpha_of(Label::undecided, 0.5f), 0.0f);
}

TEST(Paint, SurvivesSenselessOptions) {
  OverlayOptions options;
  for (const double value : {0.0, -5.0, std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    options.opacity_per_m = value;
    options.constant_alpha = value;
    const show::Paint paint{options};
    for (const auto& label : kLabels) {
      const float alpha = paint.alpha_of(label.label, 0.01f);
      EXPECT_GE(alpha, 0.0f);
      EXPECT_LE(alpha, 1.0f);
    }
    EXPECT_GT(show::draw_legend(640, {true, true, true, true}, options).height(), 20);
  }
}

TEST(Paint, MixesAndCoversExactly) {
  OverlayOptions options;
  options.opacity_per_m = 10;
  const show::Paint paint{options};
  EXPECT_EQ(paint.cover({100, 100, 100}, Label::closer, -0.1f), info(Label::closer).paper_color);
  EXPECT_EQ(paint.cover({100, 100, 100}, Label::agrees, 0.1f), (Rgb8{100, 100, 100}));
  const Rgb8 half = paint.cover({100, 100, 100}, Label::closer, -0.05f);
  EXPECT_NEAR(half.r, 165, 1);
  EXPECT_NEAR(half.g, 60, 1);
}

TEST(Legend, TheBarEndsWhereColorsAreSolidOrBeyondALargeThreshold) {
  OverlayOptions options;
  options.opacity_per_m = 25;
  const auto end_with = [&](double smallest_change_m) {
    options.smallest_change_m = smallest_change_m;
    return show::bar_end_m(options);
  };
  for (const double small : {0.0, 0.003, 0.02, -1.0, std::numeric_limits<double>::quiet_NaN(), 1e30}) {
    EXPECT_DOUBLE_EQ(end_with(small), 0.04) << small;
  }
  EXPECT_DOUBLE_EQ(end_with(0.021), 0.05);
  EXPECT_DOUBLE_EQ(end_with(0.05), 0.1);
  EXPECT_DOUBLE_EQ(end_with(0.06), 0.2);
  EXPECT_DOUBLE_EQ(end_with(1), 2);
}

TEST(Legend, TheBarIsGreyWhereNothingCanBeSeen) {
  const auto greys = [](double smallest_change_m) {
    OverlayOptions options;
    options.smallest_change_m = smallest_change_m;
    const auto legend = show::draw_legend(640, {}, options);
    return std::count_if(legend.pixels().begin(), legend.pixels().end(),
                         [](const Rgb8& p) { return p.r == p.g && p.g == p.b && p.r > 100 && p.r < 160; });
  };
  // The bar is 12 pixels high or more; a quarter of its half is 10 mm.
  EXPECT_GT(greys(0.02), greys(0.01) + 500);
  EXPECT_GT(greys(0.01), greys(0) + 500);
}

TEST(Legend, ShowsTheSwatchesOfTheLabelsThatAreSeen) {
  const auto has = [](const ColorImage& legend, Rgb8 color) {
    return std::find(legend.pixels().begin(), legend.pixels().end(), color) != legend.pixels().end();
  };
  std::array<bool, kLabels.size()> shown{};
  shown[static_cast<std::size_t>(Label::unmodelled)] = true;
  const auto legend = show::draw_legend(640, shown, {});
  EXPECT_TRUE(has(legend, info(Label::unmodelled).paper_color));
  EXPECT_FALSE(has(legend, info(Label::unmeasured).paper_color));
  // The bar's ends are solid.
  EXPECT_TRUE(has(legend, info(Label::closer).paper_color));
  EXPECT_TRUE(has(legend, info(Label::farther).paper_color));
}

TEST(Legend, GrowsByALineForATitleHoweverLong) {
  OverlayOptions options;
  const int without = show::draw_legend(640, {}, options).height();
  options.title = std::string(1000, 'w');
  const auto with = show::draw_legend(640, {}, options);
  EXPECT_GT(with.height(), without);
  EXPECT_LT(with.height(), without + 40);
  // Nothing is written into the margin on the right.
  for (int y = 0; y < 24; ++y) EXPECT_EQ(with(638, y), with(0, 0));
}

}  // namespace
}  // namespace meshloop
