#include "server/store/scene_store.h"

#include <random>

#include "scenes.h"

namespace meshloop {
namespace {

using test::add;
using test::expect_same_content;
using test::open_or_die;
using test::patch;

class Store : public test::SceneFolder {};

ReplaceSubmesh replace(NodeId id, int seed) {
  return {id, std::make_shared<const Submesh>(patch(4, seed))};
}

TEST_F(Store, StartsEmptyAtRevisionZeroAndLeavesOneFile) {
  {
    const auto store = open_or_die(scene_);
    EXPECT_EQ(store->model()->revision, 0u);
    EXPECT_TRUE(store->model()->nodes.empty());
    EXPECT_EQ(store->next_node_id(), 1u);
    EXPECT_TRUE(store->log().value().empty());
    EXPECT_EQ(store->undo("anna").error().message, "there is nothing to undo");
    EXPECT_EQ(store->redo("anna").error().message, "there is nothing to redo");
  }
  EXPECT_TRUE(open_or_die(scene_, false)->model()->nodes.empty());
}

TEST_F(Store, KeepsEverythingOfARevisionBitForBit) {
  RevisionInfo info;
  info.accepted_ns = 123456789012345;
  info.author = "operator \xc3\xa4";
  info.summary = "two boxes";
  info.triangles_added = 64;
  info.triangles_removed = 3;
  info.pictures = {{std::byte{1}, std::byte{0}, std::byte{255}}, {}, {std::byte{7}}};
  auto moved = add(2, 9);
  moved.node.T_world_node = make_pose(
      {1.0 / 3, -2e-300, 7}, Eigen::Quaterniond{Eigen::AngleAxisd{0.1, Eigen::Vector3d(1, 2, 3).normalized()}});
  Model committed;
  {
    const auto store = open_or_die(scene_);
    const auto model = store->commit({add(1, 5), moved}, info);
    ASSERT_TRUE(model) << model.error().message;
    committed = **model;
    EXPECT_EQ(committed.revision, 1u);
  }
  const auto store = open_or_die(scene_, false);
  expect_same_content(*store->model(), committed);
  EXPECT_EQ(store->model()->revision, 1u);
  EXPECT_EQ(store->next_node_id(), 3u);
  const auto log = store->log();
  ASSERT_TRUE(log) << log.error().message;
  ASSERT_EQ(log->size(), 1u);
  EXPECT_EQ((*log)[0].revision, 1u);
  EXPECT_EQ((*log)[0].parent, 0u);
  EXPECT_EQ((*log)[0].accepted_ns, info.accepted_ns);
  EXPECT_EQ((*log)[0].author, info.author);
  EXPECT_EQ((*log)[0].summary, info.summary);
  EXPECT_EQ((*log)[0].triangles_added, 64u);
  EXPECT_EQ((*log)[0].triangles_removed, 3u);
  EXPECT_EQ((*log)[0].pictures, info.pictures);
}

TEST_F(Store, KeepsGeometryWithoutColors) {
  Submesh plain = patch(2, 1);
  plain.colors.clear();
  open_or_die(scene_)->commit({AddNode{make_node(1, "", plain)}}, {}).value();
  EXPECT_FALSE(open_or_die(scene_)->model()->nodes[0].submesh->has_colors());
}

TEST_F(Store, TellsWhatUndoAndRedoWouldShow) {
  const auto store = open_or_die(scene_);
  EXPECT_FALSE(store->shown_by_undo().value());
  EXPECT_FALSE(store->shown_by_redo().value());
  store->commit({add(1, 1)}, {}).value();
  store->commit({add(2, 2)}, {}).value();
  const auto expect_true = [&](bool back) {
    const auto told = back ? store->shown_by_undo() : store->shown_by_redo();
    const auto expected = store->model_at(told.value().value()).value();
    const auto shown = (back ? store->undo("anna") : store->redo("anna")).value();
    ASSERT_EQ(shown->nodes.size(), expected->nodes.size());
    for (std::size_t i = 0; i < shown->nodes.size(); ++i) EXPECT_EQ(shown->nodes[i].hash, expected->nodes[i].hash);
  };
  expect_true(true);
  expect_true(true);
  EXPECT_EQ(store->model()->triangle_count(), 0u);
  EXPECT_FALSE(store->shown_by_undo().value());
  expect_true(false);
  expect_true(false);
  EXPECT_FALSE(store->shown_by_redo().value());
}

TEST_F(Store, UndoAndRedoAreNewRevisions) {
  const auto store = open_or_die(scene_);
  const auto one = store->commit({add(1, 1)}, {}).value();
  const auto two = store->commit({add(2, 2)}, {}).value();
  const auto three = store->commit({RemoveNode{1}, replace(2, 3)}, {}).value();
  const auto four = store->undo("anna").value();
  EXPECT_EQ(four->revision, 4u);
  expect_same_content(*four, *two);
  expect_same_content(*store->undo("anna").value(), *one);
  EXPECT_TRUE(store->undo("anna").value()->nodes.empty());
  EXPECT_FALSE(store->undo("anna"));
  expect_same_content(*store->redo("anna").value(), *one);
  expect_same_content(*store->redo("anna").value(), *two);
  const auto last = store->redo("anna").value();
  expect_same_content(*last, *three);
  EXPECT_EQ(last->revision, 9u);
  EXPECT_FALSE(store->redo("anna"));
  expect_same_content(*store->undo("anna").value(), *two);
  const auto log = store->log().value();
  ASSERT_EQ(log.size(), 10u);
  for (std::size_t i = 0; i < log.size(); ++i) {
    EXPECT_EQ(log[i].revision, i + 1);
    EXPECT_EQ(log[i].parent, i);
  }
  EXPECT_EQ(log[3].summary, "undo of revision 3");
  EXPECT_EQ(log[8].summary, "redo of revision 3");
  EXPECT_EQ(log[3].author, "anna");
  EXPECT_EQ(log[8].author, "anna");
}

TEST_F(Store, UndoSwapsTheTrianglesOfTheJournal) {
  const auto store = open_or_die(scene_);
  RevisionInfo info;
  info.triangles_added = 5;
  info.triangles_removed = 2;
  store->commit({add(1, 1)}, info).value();
  store->undo("anna").value();
  store->redo("anna").value();
  const auto log = store->log().value();
  EXPECT_EQ(log[1].triangles_added, 2u);
  EXPECT_EQ(log[1].triangles_removed, 5u);
  EXPECT_EQ(log[2].triangles_added, 5u);
}

TEST_F(Store, ACommitAfterUndoMakesRedoUnreachableButKeepsTheRevision) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1)}, {}).value();
  const auto undone = store->commit({add(2, 2)}, {}).value();
  store->undo("anna").value();
  store->commit({add(3, 3)}, {}).value();
  EXPECT_FALSE(store->redo("anna"));
  expect_same_content(*store->model_at(2).value(), *undone);
  const auto back = store->undo("anna").value();
  ASSERT_EQ(back->nodes.size(), 1u);
  EXPECT_EQ(back->nodes[0].id, 1u);
}

TEST_F(Store, UndoWorksAfterReopening) {
  open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  open_or_die(scene_)->commit({add(2, 2)}, {}).value();
  EXPECT_EQ(open_or_die(scene_)->undo("anna").value()->nodes.size(), 1u);
  EXPECT_EQ(open_or_die(scene_)->redo("anna").value()->nodes.size(), 2u);
}

TEST_F(Store, EveryRevisionOfARandomHistoryComesBack) {
  std::mt19937 random{5};
  std::vector<std::shared_ptr<const Model>> history;
  {
    const auto store = open_or_die(scene_);
    history.push_back(store->model());
    for (int step = 0; step < 60; ++step) {
      const auto now = store->model();
      const int seed = static_cast<int>(random() % 1000);
      std::vector<Edit> edits{add(store->next_node_id(), seed)};
      if (!now->nodes.empty()) {
        const NodeId id = now->nodes[random() % now->nodes.size()].id;
        const auto kind = random() % 3;
        if (kind == 0) edits = {RemoveNode{id}};
        if (kind == 1) edits = {replace(id, seed)};
        if (kind == 2) edits.push_back(MoveNode{id, make_pose({seed * 0.1, 0, 0}, Eigen::Quaterniond::Identity())});
      }
      const auto dice = random() % 6;
      auto next = dice == 0 ? store->undo("anna") : dice == 1 ? store->redo("anna") : store->commit(edits, {});
      if (next) history.push_back(*next);
    }
  }
  const auto store = open_or_die(scene_, false);
  ASSERT_GT(history.size(), 40u);
  for (const auto& model : history) {
    const auto read = store->model_at(model->revision);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ((*read)->revision, model->revision);
    expect_same_content(**read, *model);
  }
  EXPECT_FALSE(store->model_at(history.size()));
  EXPECT_FALSE(store->model_at(~Revision{0}));
}

TEST_F(Store, UnchangedGeometryIsStoredOnceAndSharedInMemory) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1, 60)}, {}).value();
  const auto size_before = std::filesystem::file_size(scene_) + std::filesystem::file_size(scene_.string() + "-wal");
  for (int i = 1; i <= 20; ++i) {
    store->commit({MoveNode{1, make_pose({0.1 * i, 0, 0}, Eigen::Quaterniond::Identity())}}, {}).value();
  }
  EXPECT_EQ(store->model_at(3).value()->nodes[0].submesh, store->model()->nodes[0].submesh);
  const auto reopened = open_or_die(scene_);
  const auto size_after = std::filesystem::file_size(scene_) + std::filesystem::file_size(scene_.string() + "-wal");
  // A move costs pages of the journal and the node table, not the 130 kB of the geometry.
  EXPECT_LT(size_after, size_before + 20 * 30'000);
}

TEST_F(Store, RefusesEditsThatDoNotFitAndStaysAsItWas) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1), add(2, 2)}, {}).value();
  store->commit({RemoveNode{2}}, {}).value();
  EXPECT_FALSE(store->commit({add(1, 3)}, {}));
  EXPECT_NE(store->commit({add(2, 3)}, {}).error().message.find("used before"), std::string::npos);
  EXPECT_FALSE(store->commit({RemoveNode{1}, add(1, 3)}, {}));
  EXPECT_FALSE(store->commit({add(0, 3)}, {}));
  EXPECT_FALSE(store->commit({add(~NodeId{0}, 3)}, {}));
  EXPECT_FALSE(store->commit({RemoveNode{7}}, {}));
  EXPECT_FALSE(store->commit({add(9, 3), RemoveNode{7}}, {}));
  EXPECT_EQ(store->model()->revision, 2u);
  EXPECT_EQ(store->next_node_id(), 3u);
  EXPECT_TRUE(store->commit({add(3, 3)}, {}));
}

TEST_F(Store, TrustsNoHashOfItsCaller) {
  auto wrong = add(1, 1);
  wrong.node.hash = {};
  const auto model = open_or_die(scene_)->commit({wrong}, {}).value();
  EXPECT_EQ(model->nodes[0].hash, content_hash(*model->nodes[0].submesh));
  expect_same_content(*open_or_die(scene_)->model(), *model);
}

TEST_F(Store, NodeIdsAreNeverFreeAgain) {
  {
    const auto store = open_or_die(scene_);
    store->commit({add(40, 1)}, {}).value();
    store->commit({RemoveNode{40}}, {}).value();
    store->undo("anna").value();
    store->undo("anna").value();
  }
  EXPECT_EQ(open_or_die(scene_)->next_node_id(), 41u);
}

TEST_F(Store, EpochsGrowAcrossRestarts) {
  {
    const auto store = open_or_die(scene_);
    EXPECT_EQ(store->begin_epoch().value(), 1u);
    EXPECT_EQ(store->begin_epoch().value(), 2u);
  }
  EXPECT_EQ(open_or_die(scene_)->begin_epoch().value(), 3u);
}

TEST_F(Store, DoesNotMakeAFileUnlessAsked) {
  const auto store = SceneStore::open(scene_, false);
  ASSERT_FALSE(store);
  EXPECT_NE(store.error().message.find("does not exist"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
  const auto lost = SceneStore::open(folder_ / "no" / "a.scene", true);
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().message.find("cannot make the scene"), std::string::npos) << lost.error().message;
}

}  // namespace
}  // namespace meshloop
