#pragma once
#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace meshloop {

/// What a full queue does with one more element. Live video drops the oldest; model updates wait, nothing is lost.
enum class WhenFull { drop_oldest, wait };

/// A queue between two threads that never grows beyond its capacity. All functions may be called from any thread.
template <class T>
class BoundedQueue {
 public:
  /// A capacity of 0 counts as 1.
  BoundedQueue(std::size_t capacity, WhenFull when_full)
      : capacity_{std::max<std::size_t>(capacity, 1)}, when_full_{when_full} {}

  /// False when the queue is closed; the element is then dropped.
  bool push(T element) {
    std::unique_lock lock{mutex_};
    if (when_full_ == WhenFull::wait) {
      space_.wait(lock, [&] { return closed_ || elements_.size() < capacity_; });
    }
    if (closed_) return false;
    if (elements_.size() >= capacity_) {
      elements_.pop_front();
      ++dropped_;
    }
    elements_.push_back(std::move(element));
    filled_.notify_one();
    return true;
  }

  /// Waits for an element. Nothing when the queue is closed and empty.
  std::optional<T> pop() {
    std::unique_lock lock{mutex_};
    filled_.wait(lock, [&] { return closed_ || !elements_.empty(); });
    return take(lock);
  }

  /// Does not wait.
  std::optional<T> try_pop() {
    std::unique_lock lock{mutex_};
    return take(lock);
  }

  /// Whether `pop` would have to wait now.
  [[nodiscard]] bool would_wait() const {
    const std::scoped_lock lock{mutex_};
    return !closed_ && elements_.empty();
  }

  /// Ends all waiting. What is in the queue can still be popped.
  void close() {
    const std::scoped_lock lock{mutex_};
    closed_ = true;
    filled_.notify_all();
    space_.notify_all();
  }

  /// How many elements made room for newer ones.
  [[nodiscard]] std::size_t dropped() const {
    const std::scoped_lock lock{mutex_};
    return dropped_;
  }

 private:
  std::optional<T> take(std::unique_lock<std::mutex>&) {
    if (elements_.empty()) return std::nullopt;
    std::optional<T> element{std::move(elements_.front())};
    elements_.pop_front();
    space_.notify_one();
    return element;
  }

  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::condition_variable space_;
  std::deque<T> elements_;
  std::size_t capacity_;
  std::size_t dropped_ = 0;
  WhenFull when_full_;
  bool closed_ = false;
};

}  // namespace meshloop
