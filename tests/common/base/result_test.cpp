#include "common/base/result.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/base/clock.h"

namespace meshloop {
namespace {

TEST(Result, AnErrorThatIsHandedOnKeepsItsKindAndSaysWhatWasDone) {
  const Result<int> inner = fail("no camera", ErrorKind::hardware_missing);
  const Status outer = fail("starting", inner.error());
  EXPECT_EQ(outer.error().message, "starting: no camera");
  EXPECT_EQ(outer.error().kind, ErrorKind::hardware_missing);
}

TEST(Result, KindsHaveTheDocumentedExitCodes) {
  EXPECT_EQ(exit_code(ErrorKind::failed), 1);
  EXPECT_EQ(exit_code(ErrorKind::usage), 2);
  EXPECT_EQ(exit_code(ErrorKind::hardware_missing), 3);
}

TEST(Stopwatch, MeasuresMillisecondsSinceItsStart) {
  Stopwatch stopwatch;
  std::this_thread::sleep_for(std::chrono::milliseconds{20});
  EXPECT_GE(stopwatch.milliseconds(), 20.0);
  EXPECT_LT(stopwatch.milliseconds(), 20'000.0);
  const double before = stopwatch.milliseconds();
  stopwatch.restart();
  EXPECT_LT(stopwatch.milliseconds(), before);
}

TEST(WallClock, CountsNanosecondsOfThisCentury) {
  constexpr std::int64_t kYear2020_ns = 1'577'836'800'000'000'000;
  EXPECT_GT(wall_clock_ns(), kYear2020_ns);
}

}  // namespace
}  // namespace meshloop
