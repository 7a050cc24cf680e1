#include "server/compare/background_comparator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "comparator_fixture.h"

namespace meshloop {
namespace {

using namespace compare_test;

class BackgroundComparatorTest : public ComparatorTest {
 protected:
  void SetUp() override {
    ComparatorTest::SetUp();
    auto background = BackgroundComparator::create();
    ASSERT_TRUE(background) << background.error().message;
    background_ = std::move(*background);
    look_at(model_, 1);
    input_.wait_for_detail = true;
  }
  /// The room with its surfaces somewhat nearer.
  DepthImage nearer_by(float step_m) const {
    DepthImage depth = measured_;
    for (float& z : depth.pixels()) z = z > 0 ? z - step_m : 0;
    return depth;
  }

  std::unique_ptr<BackgroundComparator> background_;
};

bool are_equal(const Comparison& a, const Comparison& b) {
  return std::ranges::equal(a.labels.pixels(), b.labels.pixels()) &&
         std::ranges::equal(a.threshold_m.pixels(), b.threshold_m.pixels()) &&
         std::ranges::equal(a.expected.pixels(), b.expected.pixels()) &&
         std::ranges::equal(a.node_index.pixels(), b.node_index.pixels());
}

TEST_F(BackgroundComparatorTest, FindsWhatAComparatorFinds) {
  auto pending = background_->begin(input_);
  const auto found = pending.take();
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(are_equal(found->comparison, on_gpu()));
  EXPECT_GT(found->total_ms, 0);
  EXPECT_GE(found->total_ms, found->times.render_ms);
}

TEST_F(BackgroundComparatorTest, GivesEachFrameItsOwnResultWhileOthersWait) {
  std::vector<DepthImage> measured;
  for (int i = 0; i < 6; ++i) measured.push_back(nearer_by(0.02F * static_cast<float>(i)));
  std::vector<PendingComparison> pending;
  for (const auto& depth : measured) {
    input_.measured = &depth;
    pending.push_back(background_->begin(input_));
  }
  for (std::size_t i = measured.size(); i-- > 0;) {
    const auto found = pending[i].take();
    ASSERT_TRUE(found) << found.error().message;
    input_.measured = &measured[i];
    EXPECT_TRUE(are_equal(found->comparison, on_gpu())) << i;
  }
}

// The station draws pictures in a context of its own meanwhile.
TEST_F(BackgroundComparatorTest, LeavesOtherContextsAlone) {
  const Comparison expected = on_gpu();
  for (int i = 0; i < 5; ++i) {
    auto pending = background_->begin(input_);
    EXPECT_TRUE(are_equal(on_gpu(), expected));
    const auto found = pending.take();
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_TRUE(are_equal(found->comparison, expected));
  }
}

TEST_F(BackgroundComparatorTest, RefusesWhatAComparatorRefusesAndGoesOn) {
  CompareInput wrong = input_;
  wrong.pose.state = TrackState::lost;
  EXPECT_FALSE(background_->begin(wrong).take());
  EXPECT_TRUE(background_->begin(input_).take());
}

}  // namespace
}  // namespace meshloop
