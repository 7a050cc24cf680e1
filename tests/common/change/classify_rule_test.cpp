#include "common/change/classify_rule.h"

#include <gtest/gtest.h>

#include <limits>

namespace meshloop::rule {
namespace {

constexpr float kThreshold = 0.01F;

// At a pixel whose surroundings are the pixel itself.
Label label_of(float measured_m, float expected_m, float threshold_m = kThreshold) {
  return static_cast<Label>(classify(measured_m, expected_m, threshold_m, expected_m, expected_m, !(expected_m > 0)));
}

Label label_beside(float measured_m, float expected_m, float nearest_m, float farthest_m, bool has_gap = false) {
  return static_cast<Label>(classify(measured_m, expected_m, kThreshold, nearest_m, farthest_m, has_gap));
}

TEST(ClassifyRule, NothingMeasuredIsUnmeasuredWhateverIsExpected) {
  EXPECT_EQ(label_of(0, 2), Label::unmeasured);
  EXPECT_EQ(label_of(0, 0), Label::unmeasured);
  EXPECT_EQ(label_of(0, 2, kNoThreshold_m), Label::unmeasured);
}

TEST(ClassifyRule, WhatIsNotADepthIsUnmeasured) {
  EXPECT_EQ(label_of(-1, 2), Label::unmeasured);
  EXPECT_EQ(label_of(std::numeric_limits<float>::quiet_NaN(), 2), Label::unmeasured);
}

TEST(ClassifyRule, NothingExpectedIsUnmodelled) {
  EXPECT_EQ(label_of(2, 0), Label::unmodelled);
  EXPECT_EQ(label_of(2, 0, kNoThreshold_m), Label::unmodelled);
}

TEST(ClassifyRule, DifferenceDecidesOnBothSidesOfTheThreshold) {
  EXPECT_EQ(label_of(2.009F, 2), Label::agrees);
  EXPECT_EQ(label_of(1.991F, 2), Label::agrees);
  EXPECT_EQ(label_of(2.011F, 2), Label::farther);
  EXPECT_EQ(label_of(1.989F, 2), Label::closer);
}

TEST(ClassifyRule, DifferenceOfExactlyTheThresholdAgrees) {
  EXPECT_EQ(label_of(2.25F, 2, 0.25F), Label::agrees);
  EXPECT_EQ(label_of(1.75F, 2, 0.25F), Label::agrees);
}

TEST(ClassifyRule, NoThresholdLeavesAModelledPixelUndecided) {
  EXPECT_EQ(label_of(2, 2, kNoThreshold_m), Label::undecided);
  EXPECT_EQ(label_of(1, 2, kNoThreshold_m), Label::undecided);
}

TEST(ClassifyRule, SurfaceBesideThePixelExplainsAMeasurement) {
  EXPECT_EQ(label_beside(1, 2, 1, 2), Label::undecided);
  EXPECT_EQ(label_beside(2, 1, 1, 2), Label::undecided);
  EXPECT_EQ(label_beside(2, 0, 2, 2, true), Label::undecided);
}

TEST(ClassifyRule, MixtureOfTwoSurfacesAtAnEdgeIsUndecided) {
  EXPECT_EQ(label_beside(1.5F, 2, 1, 2), Label::undecided);
}

TEST(ClassifyRule, WhatNoSurfaceInReachExplainsIsAChange) {
  EXPECT_EQ(label_beside(0.9F, 2, 1, 2), Label::closer);
  EXPECT_EQ(label_beside(2.1F, 1, 1, 2), Label::farther);
  EXPECT_EQ(label_beside(3, 0, 1, 2, true), Label::unmodelled);
}

TEST(ClassifyRule, PastTheSilhouetteFartherIsUndecidedButCloserIsNot) {
  EXPECT_EQ(label_beside(3, 1, 1, 1, true), Label::undecided);
  EXPECT_EQ(label_beside(0.5F, 1, 1, 1, true), Label::closer);
}

TEST(ClassifyRule, SurroundingsAreNeededOnlyWhereTheyCanDecide) {
  EXPECT_FALSE(needs_neighbourhood(0, 2, kThreshold));
  EXPECT_FALSE(needs_neighbourhood(2, 2, kThreshold));
  EXPECT_FALSE(needs_neighbourhood(1, 2, kNoThreshold_m));
  EXPECT_TRUE(needs_neighbourhood(1, 2, kThreshold));
  EXPECT_TRUE(needs_neighbourhood(2, 0, kThreshold));
}

}  // namespace
}  // namespace meshloop::rule
