// The figures of server/store/README.md. Run them with
//   test-server-store --gtest_also_run_disabled_tests --gtest_filter='*Figures*'
#include <fmt/format.h>

#include "common/base/clock.h"
#include "scenes.h"

namespace meshloop {
namespace {

class StoreFigures : public test::SceneFolder {};

TEST_F(StoreFigures, DISABLED_CommitAndOpen) {
  {
    const auto store = test::open_or_die(scene_);
    for (int i = 0; i < 10; ++i) {
      std::vector<Edit> edits{test::add(store->next_node_id(), i, 100)};
      const Stopwatch watch;
      store->commit(edits, {}).value();
      fmt::print("commit of 20000 triangles: {:.1f} ms\n", watch.milliseconds());
    }
    const Stopwatch moving;
    store->commit({MoveNode{1, make_pose({1, 0, 0}, Eigen::Quaterniond::Identity())}}, {}).value();
    fmt::print("commit of a move: {:.1f} ms\n", moving.milliseconds());
    const Stopwatch undoing;
    store->undo("anna").value();
    fmt::print("undo: {:.1f} ms\n", undoing.milliseconds());
    std::vector<Edit> large;
    for (int i = 0; i < 50; ++i) large.emplace_back(test::add(store->next_node_id() + NodeId(i), 100 + i, 158));
    const Stopwatch importing;
    store->commit(large, {}).value();
    fmt::print("commit of 50 nodes of 50000 triangles: {:.0f} ms\n", importing.milliseconds());
  }
  const Stopwatch opening;
  const auto store = test::open_or_die(scene_);
  fmt::print("opening {} triangles ({} MB): {:.0f} ms\n", store->model()->triangle_count(),
             std::filesystem::file_size(scene_) / 1'000'000, opening.milliseconds());
}

}  // namespace
}  // namespace meshloop
