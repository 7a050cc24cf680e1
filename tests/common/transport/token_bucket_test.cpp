#include "common/transport/token_bucket.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

const TokenBucket::Time kStart{};

TEST(TokenBucket, LetsTheFirstBurstGoAtOnce) {
  const TokenBucket bucket{1000.0, 500.0, kStart};
  EXPECT_EQ(bucket.wait_before(500, kStart).count(), 0);
}

TEST(TokenBucket, MakesTheNextMessageWaitForItsShareOfTheRate) {
  TokenBucket bucket{1000.0, 500.0, kStart};
  bucket.take(500, kStart);
  EXPECT_EQ(bucket.wait_before(200, kStart), nanoseconds{milliseconds{200}});
  EXPECT_EQ(bucket.wait_before(200, kStart + milliseconds{150}), nanoseconds{milliseconds{50}});
  EXPECT_EQ(bucket.wait_before(200, kStart + milliseconds{200}).count(), 0);
}

TEST(TokenBucket, DoesNotSaveMoreThanOneBurstInQuietTimes) {
  TokenBucket bucket{1000.0, 500.0, kStart};
  const auto later = kStart + std::chrono::hours{1};
  bucket.take(500, later);
  EXPECT_EQ(bucket.wait_before(100, later), nanoseconds{milliseconds{100}});
}

TEST(TokenBucket, AMessageLargerThanTheBucketLeavesADebt) {
  TokenBucket bucket{1000.0, 500.0, kStart};
  ASSERT_EQ(bucket.wait_before(2000, kStart).count(), 0);
  bucket.take(2000, kStart);
  EXPECT_EQ(bucket.wait_before(100, kStart), nanoseconds{milliseconds{1600}});
}

TEST(TokenBucket, KeepsTheRateOverManyMessages) {
  TokenBucket bucket{5e6, 1e6, kStart};
  auto now = kStart;
  for (int i = 0; i < 1000; ++i) {
    now += bucket.wait_before(30'000, now);
    bucket.take(30'000, now);
  }
  const double elapsed_s = std::chrono::duration<double>(now - kStart).count();
  EXPECT_NEAR(elapsed_s, (30e6 - 1e6) / 5e6, 0.01);
}

TEST(TokenBucket, AClockThatStandsStillTakesNothingAway) {
  TokenBucket bucket{1000.0, 500.0, kStart + milliseconds{100}};
  EXPECT_EQ(bucket.wait_before(500, kStart).count(), 0);
}

}  // namespace
}  // namespace meshloop
