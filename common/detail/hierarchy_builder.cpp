#include "common/detail/hierarchy_builder.h"

#include <sys/resource.h>

#include <algorithm>
#include <new>
#include <utility>

namespace meshloop {
namespace {

/// Null when memory is short: the submesh is then drawn exactly.
std::unique_ptr<ClusterHierarchy> built(const Submesh& submesh) {
  try {
    return std::make_unique<ClusterHierarchy>(build_hierarchy(submesh));
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

}  // namespace

HierarchyBuilder::HierarchyBuilder(unsigned threads, Priority priority) {
  for (unsigned i = 0; i < std::max(1U, threads); ++i) threads_.emplace_back([=, this] { work(priority); });
}

HierarchyBuilder::~HierarchyBuilder() {
  {
    const std::scoped_lock lock{mutex_};
    ending_ = true;
  }
  changed_.notify_all();
}

void HierarchyBuilder::ask(const std::shared_ptr<const Submesh>& submesh) {
  {
    const std::scoped_lock lock{mutex_};
    asked_.push_back(submesh);
  }
  changed_.notify_all();
}

HierarchyBuilder::Built HierarchyBuilder::take() {
  const std::scoped_lock lock{mutex_};
  if (ready_.empty()) return {};
  Built built = std::move(ready_.front());
  ready_.pop_front();
  return built;
}

bool HierarchyBuilder::wait_for_next() {
  std::unique_lock lock{mutex_};
  changed_.wait(lock, [&] { return !ready_.empty() || (asked_.empty() && being_built_ == 0); });
  return !ready_.empty();
}

void HierarchyBuilder::work(Priority priority) {
  constexpr int kYielding = 10;
  // Linux: of this thread alone; the system holds it to 19.
  if (priority == Priority::yielding) setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kYielding);
  std::unique_lock lock{mutex_};
  for (;;) {
    changed_.wait(lock, [&] { return ending_ || !asked_.empty(); });
    if (ending_) return;
    const auto submesh = asked_.front().lock();
    asked_.pop_front();
    ++being_built_;
    lock.unlock();
    auto hierarchy = submesh ? built(*submesh) : nullptr;
    lock.lock();
    --being_built_;
    if (hierarchy) ready_.push_back({submesh, std::move(hierarchy)});
    changed_.notify_all();
  }
}

}  // namespace meshloop
