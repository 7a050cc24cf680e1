#include "scenes.h"
#include "server/store/scene_store.h"

namespace meshloop {
namespace {

using test::add;
using test::expect_same_content;
using test::open_or_die;

class Restore : public test::SceneFolder {
 protected:
  /// Three changes of a node each; the scene then shows the last.
  std::unique_ptr<SceneStore> three_changes() {
    auto store = open_or_die(scene_);
    for (NodeId id = 1; id <= 3; ++id) store->commit({add(id, static_cast<int>(id))}, {}).value();
    return store;
  }
};

TEST_F(Restore, ShowsAnyRevisionAgainAsANewOne) {
  const auto store = three_changes();
  for (const Revision revision : {1u, 3u, 0u, 2u}) {
    const Revision before = store->model()->revision;
    const auto then = store->model_at(revision).value();
    const auto restored = store->restore(revision, "anna");
    ASSERT_TRUE(restored) << restored.error().message;
    EXPECT_EQ((*restored)->revision, before + 1);
    expect_same_content(**restored, *then);
    EXPECT_EQ(store->model(), *restored);
  }
  expect_same_content(*open_or_die(scene_)->model(), *store->model_at(2).value());
}

TEST_F(Restore, IsTakenBackByUndoAndBroughtAgainByRedo) {
  const auto store = three_changes();
  const auto three = store->model();
  const auto one = store->restore(1, "anna").value();
  expect_same_content(*store->undo("anna").value(), *three);
  expect_same_content(*store->redo("anna").value(), *one);
  expect_same_content(*store->undo("anna").value(), *three);
  expect_same_content(*store->undo("anna").value(), *store->model_at(2).value());
}

TEST_F(Restore, ReachesWhatRedoNoLongerDoes) {
  const auto store = three_changes();
  const auto three = store->model();
  store->undo("anna").value();
  store->commit({add(4, 4)}, {}).value();
  EXPECT_FALSE(store->redo("anna"));
  expect_same_content(*store->restore(3, "anna").value(), *three);
}

TEST_F(Restore, EndsRedoAsAnyChangeDoes) {
  const auto store = three_changes();
  store->undo("anna").value();
  store->restore(1, "anna").value();
  EXPECT_EQ(store->redo("anna").error().message, "there is nothing to redo");
}

TEST_F(Restore, RefusesWhatIsNotThereAndWhatIsSoAlready) {
  const auto store = three_changes();
  for (const Revision revision : {Revision{4}, ~Revision{0}}) {
    const auto refused = store->restore(revision, "anna");
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("has no revision"), std::string::npos) << refused.error().message;
  }
  EXPECT_EQ(store->restore(3, "anna").error().message, "the scene is as it was at revision 3 already");
  store->undo("anna").value();
  EXPECT_FALSE(store->restore(2, "anna")) << "revision 4 shows it";
  EXPECT_EQ(store->model()->revision, 4u);
  EXPECT_EQ(store->log().value().size(), 4u);
}

TEST_F(Restore, TellsBitsApartThatAreEqualNumbers) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1)}, {}).value();
  Pose other = Pose::Identity();
  other.translation().x() = -0.0;
  store->commit({MoveNode{1, other}}, {}).value();
  EXPECT_TRUE(std::signbit(open_or_die(scene_)->model()->nodes[0].T_world_node.translation().x()));
  const auto restored = store->restore(1, "anna");
  ASSERT_TRUE(restored) << restored.error().message;
  EXPECT_FALSE(std::signbit((*restored)->nodes[0].T_world_node.translation().x()));
}

TEST_F(Restore, TheJournalSaysWhoAndCountsTheNetOfEachNode) {
  const auto store = three_changes();
  // Node 1 loses 24 of its 32 triangles, node 2 goes, node 4 comes.
  store
      ->commit({ReplaceSubmesh{1, std::make_shared<const Submesh>(test::patch(2, 9))}, RemoveNode{2}, add(4, 4, 3)}, {})
      .value();
  store->restore(3, "anna").value();
  store->undo("bert").value();
  const auto log = store->log().value();
  ASSERT_EQ(log.size(), 6u);
  EXPECT_EQ(log[4].summary, "revision 3 restored");
  EXPECT_EQ(log[4].author, "anna");
  EXPECT_EQ(log[4].triangles_added, 24u + 32u);
  EXPECT_EQ(log[4].triangles_removed, 18u);
  EXPECT_GT(log[4].accepted_ns, 0);
  EXPECT_EQ(log[5].summary, "undo of revision 5");
  EXPECT_EQ(log[5].author, "bert");
  EXPECT_EQ(log[5].triangles_added, 18u);
}

}  // namespace
}  // namespace meshloop
