#pragma once
// Comparisons beside the program: who begins one can track, read and draw until its result is there.
#include <functional>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "common/base/bounded_queue.h"
#include "server/compare/comparator.h"

namespace meshloop {

struct TimedComparison {
  Comparison comparison;
  CompareTimes times;
  /// Of the whole comparison, without waiting for its turn.
  double total_ms = 0;
};

/// A comparison that is under way, or done and not taken yet. Its end waits for it, so that what it reads can be freed
/// afterwards.
class PendingComparison {
 public:
  explicit PendingComparison(std::future<Result<TimedComparison>> result) : result_{std::move(result)} {}
  ~PendingComparison() {
    if (result_.valid()) result_.wait();
  }
  PendingComparison(PendingComparison&&) = default;
  PendingComparison(const PendingComparison&) = delete;
  PendingComparison& operator=(const PendingComparison&) = delete;
  PendingComparison& operator=(PendingComparison&&) = delete;

  /// Waits for the result. Once. Throws nothing that the comparison threw: a lack of memory is an error like others.
  [[nodiscard]] Result<TimedComparison> take() { return result_.get(); }

 private:
  std::future<Result<TimedComparison>> result_;
};

/// A Comparator with a thread and a GPU context of its own: drawing, comparing and reading back happen there, and the
/// next frame waits for none of them. Comparisons are made one after the other, in the order in which they begin. All
/// functions from any thread.
class BackgroundComparator {
 public:
  using Factory = std::function<Result<std::unique_ptr<Comparator>>()>;
  /// `make` is called on the thread, and what it makes ends there: by default a Comparator with a context of its own.
  [[nodiscard]] static Result<std::unique_ptr<BackgroundComparator>> create(const Factory& make = comparator_on_gpu);
  /// Waits for what has begun.
  ~BackgroundComparator();
  BackgroundComparator(const BackgroundComparator&) = delete;
  BackgroundComparator& operator=(const BackgroundComparator&) = delete;

  /// Everything that `input` points to must stay as it is until the result is taken or given up. See
  /// Comparator::compare for what is refused.
  [[nodiscard]] PendingComparison begin(const CompareInput& input);

 private:
  [[nodiscard]] static Result<std::unique_ptr<Comparator>> comparator_on_gpu();
  using Task = std::packaged_task<Result<TimedComparison>(Comparator&)>;
  BackgroundComparator();
  void work(const Factory& make, std::promise<Status> created);

  BoundedQueue<Task> tasks_;
  std::jthread thread_;
};

}  // namespace meshloop
