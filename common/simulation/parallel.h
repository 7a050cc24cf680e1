#pragma once
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace meshloop::simulation {

[[nodiscard]] inline int processor_count() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Calls work(i) for i from 0 to count - 1 on `threads` threads, the caller's among them, beginning in the order of i.
/// Calls for different i must not touch the same data; the result is then the same for any number of threads.
template <class Work>
void for_each_parallel(int count, int threads, const Work& work) {
  std::atomic<int> next{0};
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < std::min(threads, count); ++i) others.emplace_back(run);
  run();
}

/// Puts results that are computed out of order back into order.
class Turns {
 public:
  /// Number `number` of those that want their turn. Its turn comes when all lower numbers are gone, and ends with its
  /// life, also on the way out of an error.
  class Turn {
   public:
    Turn(Turns& turns, int number) : turns_{turns}, number_{number} {}
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() {
      wait();
      {
        const std::lock_guard lock(turns_.mutex_);
        ++turns_.current_;
      }
      turns_.changed_.notify_all();
    }

    void wait() {
      std::unique_lock lock(turns_.mutex_);
      turns_.changed_.wait(lock, [&] { return turns_.current_ == number_; });
    }

   private:
    Turns& turns_;
    int number_;
  };

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int current_ = 0;
};

}  // namespace meshloop::simulation
