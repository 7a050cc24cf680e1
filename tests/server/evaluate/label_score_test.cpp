#include "server/evaluate/label_score.h"

#include <gtest/gtest.h>

#include <limits>

namespace meshloop {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();

// A row of pixels: what was measured and expected in truth, what the comparison said.
struct PixelCase {
  float measured;
  float expected;
  Label detected;
  float threshold_m = 0.01f;
  RegionId region = 0;
};

LabelScore score_of(const std::vector<PixelCase>& cases) {
  const int n = static_cast<int>(cases.size());
  DepthTruth truth{DepthImage{n, 1}, DepthImage{n, 1}};
  Comparison comparison;
  comparison.labels = Image<Label>{n, 1};
  comparison.threshold_m = Image<float>{n, 1};
  RegionMap regions;
  regions.ids = Image<RegionId>{n, 1};
  Region region;
  region.id = 1;
  region.confirmed = true;
  regions.regions.push_back(region);
  region.id = 2;
  region.confirmed = false;
  regions.regions.push_back(region);
  for (int i = 0; i < n; ++i) {
    const auto& one = cases[static_cast<std::size_t>(i)];
    truth.measured(i, 0) = one.measured;
    truth.expected(i, 0) = one.expected;
    comparison.labels(i, 0) = one.detected;
    comparison.threshold_m(i, 0) = one.threshold_m;
    regions.ids(i, 0) = one.region;
  }
  LabelScore score{*SensorModel::constant(0.002), 3};
  score.add(comparison, regions, truth);
  return score;
}

TEST(LabelScore, IouCountsMissesAndFalseLabels) {
  const auto score = score_of({{1.0f, 1.1f, Label::closer},
                               {1.0f, 1.1f, Label::agrees},
                               {1.0f, 1.0f, Label::closer},
                               {1.2f, 1.1f, Label::farther},
                               {1.0f, 0.0f, Label::unmodelled}});
  EXPECT_DOUBLE_EQ(score.iou(Label::closer), 1.0 / 3);
  EXPECT_DOUBLE_EQ(score.iou(Label::farther), 1);
  EXPECT_DOUBLE_EQ(score.iou(Label::unmodelled), 1);
}

TEST(LabelScore, PixelsThatWereNotMeasuredDoNotCount) {
  const auto score = score_of({{1.0f, 1.1f, Label::unmeasured}, {0.0f, 1.0f, Label::farther}});
  EXPECT_EQ(score.counts(Label::closer).either, 0U);
  EXPECT_EQ(score.counts(Label::farther).either, 0U);
}

TEST(LabelScore, RecallLooksOnlyAtDifferencesAboveTheStatedThreshold) {
  const auto score = score_of({{1.0f, 1.1f, Label::closer},
                               {1.0f, 1.1f, Label::undecided, kInfinite},
                               {1.0f, 1.1f, Label::undecided},
                               {1.0f, 1.1f, Label::farther}});
  EXPECT_DOUBLE_EQ(score.recall(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(score.undecided(), 0.5);
}

TEST(LabelScore, FalseChangeCountsConfirmedRegionsOnly) {
  const auto score = score_of({{1.0f, 1.0f, Label::closer, 0.01f, 1},
                               {1.0f, 1.0f, Label::closer, 0.01f, 2},
                               {1.0f, 1.0f, Label::agrees},
                               {1.0f, 1.0f, Label::agrees}});
  EXPECT_DOUBLE_EQ(score.false_change(), 0.25);
}

}  // namespace
}  // namespace meshloop
