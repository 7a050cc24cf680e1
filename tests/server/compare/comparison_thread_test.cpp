// The thread of a BackgroundComparator with comparators that need no GPU.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <new>
#include <thread>
#include <vector>

#include "server/compare/background_comparator.h"

namespace meshloop {
namespace {

using std::chrono::milliseconds;

class FakeComparator final : public Comparator {
 public:
  using Compare = std::function<Result<Comparison>(const CompareInput&)>;
  explicit FakeComparator(Compare compare) : compare_{std::move(compare)} {}
  Result<Comparison> compare(const CompareInput& input, CompareTimes*) override { return compare_(input); }

 private:
  Compare compare_;
};

std::unique_ptr<BackgroundComparator> background(const FakeComparator::Compare& compare) {
  return std::move(BackgroundComparator::create([&]() -> Result<std::unique_ptr<Comparator>> {
                     return std::make_unique<FakeComparator>(compare);
                   }).value());
}

/// Its expected depth is what was measured.
Result<Comparison> echo(const CompareInput& input) {
  Comparison comparison;
  comparison.expected = *input.measured;
  return comparison;
}

CompareInput input_of(const DepthImage& measured) {
  CompareInput input;
  input.measured = &measured;
  return input;
}

TEST(ComparisonThread, KeepsTheOrderAndGivesEachItsOwn) {
  std::vector<float> order;
  const auto comparator = background([&](const CompareInput& input) {
    order.push_back((*input.measured)(0, 0));
    return echo(input);
  });
  std::vector<DepthImage> measured;
  for (int i = 0; i < 40; ++i) measured.emplace_back(1, 1, static_cast<float>(i));
  std::vector<PendingComparison> pending;
  for (const auto& depth : measured) pending.push_back(comparator->begin(input_of(depth)));
  for (std::size_t i = 0; i < pending.size(); ++i) {
    const auto result = pending[i].take();
    ASSERT_TRUE(result);
    EXPECT_EQ(result->comparison.expected(0, 0), static_cast<float>(i));
  }
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], static_cast<float>(i));
}

TEST(ComparisonThread, AComparisonThatIsGivenUpHasEndedBeforeItsImageDoes) {
  std::atomic<bool> is_reading = false;
  const auto comparator = background([&](const CompareInput& input) {
    is_reading = true;
    std::this_thread::sleep_for(milliseconds{20});
    auto result = echo(input);
    is_reading = false;
    return result;
  });
  {
    const DepthImage measured(1, 1, 1.0F);
    const auto given_up = comparator->begin(input_of(measured));
    while (!is_reading) std::this_thread::yield();
  }
  EXPECT_FALSE(is_reading);
}

TEST(ComparisonThread, EndsAfterWhatHasBegun) {
  const DepthImage measured(1, 1, 1.0F);
  auto comparator = background([](const CompareInput& input) {
    std::this_thread::sleep_for(milliseconds{5});
    return echo(input);
  });
  auto first = comparator->begin(input_of(measured));
  auto second = comparator->begin(input_of(measured));
  comparator.reset();
  EXPECT_TRUE(first.take());
  EXPECT_TRUE(second.take());
}

TEST(ComparisonThread, ALackOfMemoryIsAnErrorAndTheNextOneIsCompared) {
  const DepthImage measured(1, 1, 1.0F);
  bool is_first = true;
  const auto comparator = background([&](const CompareInput& input) {
    if (std::exchange(is_first, false)) throw std::bad_alloc{};
    return echo(input);
  });
  const auto failed = comparator->begin(input_of(measured)).take();
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("bad_alloc"), std::string::npos);
  EXPECT_TRUE(comparator->begin(input_of(measured)).take());
}

TEST(ComparisonThread, SaysWhyThereIsNone) {
  const auto refused = BackgroundComparator::create(
      []() -> Result<std::unique_ptr<Comparator>> { return fail("no GPU", ErrorKind::hardware_missing); });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "no GPU");
  EXPECT_EQ(refused.error().kind, ErrorKind::hardware_missing);
  EXPECT_FALSE(BackgroundComparator::create([]() -> Result<std::unique_ptr<Comparator>> { throw std::bad_alloc{}; }));
}

TEST(ComparisonThread, SeveralThreadsMayBegin) {
  const auto comparator = background(echo);
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      const DepthImage measured(1, 1, static_cast<float>(i));
      for (int k = 0; k < 50; ++k) {
        const auto result = comparator->begin(input_of(measured)).take();
        EXPECT_TRUE(result && result->comparison.expected(0, 0) == static_cast<float>(i));
      }
    });
  }
}

}  // namespace
}  // namespace meshloop
