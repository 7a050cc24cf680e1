#include "server/capture/prefetching_source.h"

#include <gtest/gtest.h>

#include <atomic>

namespace meshloop {
namespace {

class CountingSource : public RgbdSource {
 public:
  CountingSource(int frames, int broken, std::atomic<int>& reads) : frames_{frames}, broken_{broken}, reads_{reads} {}
  [[nodiscard]] const Rig& rig() const override { return rig_; }
  [[nodiscard]] const Rig& calibration() const override { return rig_; }
  Result<std::optional<RgbdFrame>> next() override {
    ++reads_;
    const int index = next_++;
    if (index == broken_) return fail("frame is broken");
    if (index >= frames_) return std::nullopt;
    RgbdFrame frame;
    frame.index = index;
    return frame;
  }

 private:
  Rig rig_;
  int frames_;
  int broken_;
  int next_ = 0;
  std::atomic<int>& reads_;
};

TEST(PrefetchingSource, GivesEveryFrameInOrderAndTheErrorInItsPlace) {
  std::atomic<int> reads{0};
  PrefetchingSource source{std::make_unique<CountingSource>(20, 7, reads), WhenFull::wait};
  for (int i = 0; i < 20; ++i) {
    const auto frame = source.next();
    if (i == 7) {
      ASSERT_FALSE(frame);
      EXPECT_EQ(frame.error().message, "frame is broken");
      continue;
    }
    ASSERT_TRUE(frame);
    ASSERT_TRUE(*frame);
    EXPECT_EQ((*frame)->index, i);
  }
  const auto end = source.next();
  ASSERT_TRUE(end);
  EXPECT_FALSE(*end);
  const auto after_the_end = source.next();
  ASSERT_TRUE(after_the_end);
  EXPECT_FALSE(*after_the_end);
}

TEST(PrefetchingSource, EndsWhileTheQueueIsFull) {
  std::atomic<int> reads{0};
  {
    PrefetchingSource source{std::make_unique<CountingSource>(1000, -1, reads), WhenFull::wait};
    ASSERT_TRUE(source.next());
  }
  EXPECT_LT(reads, 100);
}

}  // namespace
}  // namespace meshloop
