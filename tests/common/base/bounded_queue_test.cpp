#include "common/base/bounded_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

namespace meshloop {
namespace {

TEST(BoundedQueue, DropsTheOldestWhenLiveVideoIsTooFast) {
  BoundedQueue<int> queue{2, WhenFull::drop_oldest};
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(queue.push(i));
  EXPECT_EQ(queue.dropped(), 3u);
  EXPECT_EQ(queue.try_pop(), 3);
  EXPECT_EQ(queue.try_pop(), 4);
  EXPECT_EQ(queue.try_pop(), std::nullopt);
}

TEST(BoundedQueue, TellsWhetherPopWouldWait) {
  BoundedQueue<int> queue{2, WhenFull::wait};
  EXPECT_TRUE(queue.would_wait());
  queue.push(1);
  EXPECT_FALSE(queue.would_wait());
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_TRUE(queue.would_wait());
  queue.close();
  EXPECT_FALSE(queue.would_wait());
}

TEST(BoundedQueue, KeepsOrderAndLosesNothingWhenItWaits) {
  constexpr int kCount = 2000;
  BoundedQueue<int> queue{3, WhenFull::wait};
  std::thread writer{[&] {
    for (int i = 0; i < kCount; ++i) queue.push(i);
    queue.close();
  }};
  int expected = 0;
  while (const auto element = queue.pop()) EXPECT_EQ(*element, expected++);
  writer.join();
  EXPECT_EQ(expected, kCount);
  EXPECT_EQ(queue.dropped(), 0u);
}

TEST(BoundedQueue, WaitsForSpaceUntilSomethingIsTaken) {
  BoundedQueue<int> queue{1, WhenFull::wait};
  queue.push(1);
  std::atomic<bool> pushed = false;
  std::thread writer{[&] {
    queue.push(2);
    pushed = true;
  }};
  std::this_thread::sleep_for(std::chrono::milliseconds{20});
  EXPECT_FALSE(pushed);
  EXPECT_EQ(queue.pop(), 1);
  writer.join();
  EXPECT_EQ(queue.pop(), 2);
}

TEST(BoundedQueue, CloseWakesReadersAndWritersThatWait) {
  BoundedQueue<int> empty{1, WhenFull::wait};
  BoundedQueue<int> full{1, WhenFull::wait};
  full.push(1);
  std::thread reader{[&] { EXPECT_EQ(empty.pop(), std::nullopt); }};
  std::thread writer{[&] { EXPECT_FALSE(full.push(2)); }};
  std::this_thread::sleep_for(std::chrono::milliseconds{10});
  empty.close();
  full.close();
  reader.join();
  writer.join();
}

TEST(BoundedQueue, GivesWhatIsLeftAfterClosingAndTakesNothingMore) {
  BoundedQueue<std::unique_ptr<int>> queue{2, WhenFull::drop_oldest};
  queue.push(std::make_unique<int>(7));
  queue.close();
  EXPECT_FALSE(queue.push(std::make_unique<int>(8)));
  const auto last = queue.pop();
  ASSERT_TRUE(last);
  EXPECT_EQ(**last, 7);
  EXPECT_FALSE(queue.pop());
}

TEST(BoundedQueue, CapacityOfZeroHoldsOneElement) {
  BoundedQueue<int> queue{0, WhenFull::drop_oldest};
  queue.push(1);
  queue.push(2);
  EXPECT_EQ(queue.try_pop(), 2);
  BoundedQueue<int> waiting{0, WhenFull::wait};
  EXPECT_TRUE(waiting.push(1));
}

}  // namespace
}  // namespace meshloop
