#pragma once
// Hierarchies made in the background.
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/detail/cluster_hierarchy.h"

namespace meshloop {

/// Threads that turn submeshes into hierarchies, in the order of asking. All functions from any thread.
class HierarchyBuilder {
 public:
  /// Whether the threads yield to everything else on the machine, for live programs whose frames do not wait for them.
  enum class Priority { yielding, normal };
  /// At least one thread.
  HierarchyBuilder(unsigned threads, Priority priority);
  /// Work that was not begun is given up.
  ~HierarchyBuilder();
  HierarchyBuilder(const HierarchyBuilder&) = delete;
  HierarchyBuilder& operator=(const HierarchyBuilder&) = delete;

  /// A submesh that nobody holds any more when its turn comes is passed over; one for which memory is short, too.
  void ask(const std::shared_ptr<const Submesh>& submesh);
  struct Built {
    std::shared_ptr<const Submesh> submesh;
    std::unique_ptr<ClusterHierarchy> hierarchy;
  };
  /// Hands over the next that is ready; nulls when none is.
  [[nodiscard]] Built take();
  /// Waits until one can be taken; false when nothing more comes.
  [[nodiscard]] bool wait_for_next();

 private:
  void work(Priority priority);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::weak_ptr<const Submesh>> asked_;
  std::deque<Built> ready_;
  std::size_t being_built_ = 0;
  bool ending_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace meshloop
