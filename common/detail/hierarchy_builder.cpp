#include "common/detail/hierarchy_builder.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

namespace meshloop {

HierarchyBuilder::HierarchyBuilder(unsigned threads) {
  for (unsigned i = 0; i < std::max(1U, threads); ++i) threads_.emplace_back([this] { work(); });
}

HierarchyBuilder::~HierarchyBuilder() {
  {
    const std::scoped_lock lock{mutex_};
    ending_ = true;
  }
  changed_.notify_all();
}

void HierarchyBuilder::ask(std::shared_ptr<const Submesh> submesh) {
  {
    const std::scoped_lock lock{mutex_};
    asked_.push_back(std::move(submesh));
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

void HierarchyBuilder::wait() {
  std::unique_lock lock{mutex_};
  changed_.wait(lock, [&] { return asked_.empty() && being_built_ == 0; });
}

void HierarchyBuilder::work() {
  constexpr int kYielding = 10;
  setpriority(PRIO_PROCESS, 0, kYielding);  // Linux: of this thread alone
  std::unique_lock lock{mutex_};
  for (;;) {
    changed_.wait(lock, [&] { return ending_ || !asked_.empty(); });
    if (ending_) return;
    const auto submesh = std::move(asked_.front());
    asked_.pop_front();
    ++being_built_;
    lock.unlock();
    auto hierarchy = std::make_unique<const ClusterHierarchy>(build_hierarchy(*submesh));
    lock.lock();
    --being_built_;
    ready_.push_back({submesh, std::move(hierarchy)});
    changed_.notify_all();
  }
}

}  // namespace meshloop
