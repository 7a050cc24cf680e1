#include "server/compare/background_comparator.h"

#include <exception>
#include <string>

#include "common/base/clock.h"

namespace meshloop {
namespace {

/// What `run` returns; what it throws, as an error.
template <class Run>
auto caught(Run run) -> decltype(run()) {
  try {
    return run();
  } catch (const std::exception& error) {
    return fail(std::string{"comparing: "} + error.what());
  }
}

Result<TimedComparison> timed(Comparator& comparator, const CompareInput& input) {
  const Stopwatch watch;
  TimedComparison result;
  auto comparison = comparator.compare(input, &result.times);
  if (!comparison) return fail(comparison.error());
  result.comparison = std::move(*comparison);
  result.total_ms = watch.milliseconds();
  return result;
}

class OwnContextComparator final : public Comparator {
 public:
  OwnContextComparator(std::unique_ptr<GpuContext> gpu, std::unique_ptr<Comparator> comparator)
      : gpu_{std::move(gpu)}, comparator_{std::move(comparator)} {}
  Result<Comparison> compare(const CompareInput& input, CompareTimes* times) override {
    return comparator_->compare(input, times);
  }

 private:
  std::unique_ptr<GpuContext> gpu_;
  std::unique_ptr<Comparator> comparator_;
};

}  // namespace

// More than anybody begins at once: a frame, and the next one.
BackgroundComparator::BackgroundComparator() : tasks_{16, WhenFull::wait} {}

BackgroundComparator::~BackgroundComparator() {
  tasks_.close();
}

Result<std::unique_ptr<Comparator>> BackgroundComparator::comparator_on_gpu() {
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto comparator = Comparator::create(**gpu);
  if (!comparator) return fail(comparator.error());
  return std::make_unique<OwnContextComparator>(std::move(*gpu), std::move(*comparator));
}

Result<std::unique_ptr<BackgroundComparator>> BackgroundComparator::create(const Factory& make) {
  std::unique_ptr<BackgroundComparator> made{new BackgroundComparator};
  std::promise<Status> created;
  auto status = created.get_future();
  made->thread_ = std::jthread{
      [&self = *made, &make, promise = std::move(created)]() mutable { self.work(make, std::move(promise)); }};
  if (const Status done = status.get(); !done) return fail(done.error());
  return made;
}

// `make` is there until `created` has its value.
void BackgroundComparator::work(const Factory& make, std::promise<Status> created) {
  const auto comparator = caught([&] { return make(); });
  if (!comparator) return created.set_value(fail(comparator.error()));
  created.set_value({});
  while (auto task = tasks_.pop()) (*task)(**comparator);
}

PendingComparison BackgroundComparator::begin(const CompareInput& input) {
  Task task{[input](Comparator& comparator) { return caught([&] { return timed(comparator, input); }); }};
  PendingComparison pending{task.get_future()};
  tasks_.push(std::move(task));
  return pending;
}

}  // namespace meshloop
