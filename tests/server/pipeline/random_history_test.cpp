// Random accept, undo, redo and restore: after each, the scene has the bits that it must have.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "changing_room.h"
#include "common/recording/recording.h"
#include "random_edits.h"
#include "recorded_history.h"
#include "sanitized.h"
#include "temporary_folder.h"

// In place of the C library's: what is looked at here does not depend on the disk, which would take minutes.
extern "C" int fsync(int) {
  return 0;
}
extern "C" int fdatasync(int) {
  return 0;
}

namespace meshloop {
namespace {

using test::ChangingRoom;
using test::difference;
using test::RecordedHistory;

constexpr int kSequences = test::kSanitized ? 20 : 100;
/// Of so many sequences one accepts proposals that were made from snapshots, and the others edits that are random.
constexpr int kEvery = 4;

/// What happened in all sequences together: a test that does nothing passes too.
using Tally = std::map<std::string, int>;
const Tally kNothing{{"accepted", 0}, {"accepted together", 0}, {"inserted", 0},
                     {"cut", 0},      {"rejected", 0},          {"undo", 0},
                     {"redo", 0},     {"restore", 0},           {"refused", 0}};

/// A scene and the record of what it must show.
class Sequence {
 public:
  Sequence(std::filesystem::path scene, unsigned seed, Tally& tally)
      : scene_{std::move(scene)}, random_{seed}, room_{seed}, tally_{tally} {
    open();
  }

  void random_step(bool measured) {
    switch (random_() % 10) {
      case 0:
      case 1:
        return step("undo", history_.undo(), store_->undo("anna"));
      case 2:
      case 3:
        return step("redo", history_.redo(), store_->redo("anna"));
      case 4: {
        const Revision revision = random_() % (history_.last() + 2);
        return step("restore", history_.restore(revision), store_->restore(revision, "anna"));
      }
      case 5:
        return open();
      case 6:
        return commit_what_does_not_fit();
      default:
        return measured ? accept_proposals() : accept_random_edits();
    }
  }

  void start_with_the_room() { accept(room_.model_from(store_->next_node_id())); }

  void check(const std::string& after) const {
    const auto model = store_->model();
    ASSERT_EQ(model->revision, history_.last()) << after;
    ASSERT_EQ(difference(history_.present(), *model), "") << after;
  }

  void check_all_from_the_file() {
    open();
    check("opening");
    for (Revision revision = 0; revision <= history_.last(); ++revision) {
      const auto model = store_->model_at(revision);
      ASSERT_TRUE(model) << model.error().message;
      ASSERT_EQ(difference(history_.at(revision), **model), "") << "revision " << revision;
    }
    EXPECT_FALSE(store_->model_at(history_.last() + 1));
    EXPECT_EQ(store_->log().value().size(), history_.last());
  }

 private:
  void open() {
    store_.reset();
    auto store = SceneStore::open(scene_, true);
    if (!store) throw std::runtime_error(store.error().message);
    store_ = std::move(*store);
  }

  /// The store must do what the record says, or refuse what the record refuses.
  void step(const char* name, bool expected, const Result<std::shared_ptr<const Model>>& model) {
    ASSERT_EQ(model.has_value(), expected) << name << (model ? "" : ": " + model.error().message);
    ++tally_[expected ? name : "refused"];
    check(name);
  }

  void accept(const std::vector<Edit>& edits) {
    const auto model = store_->commit_unsynced(edits, {});
    ASSERT_TRUE(model) << model.error().message;
    history_.accept(edits);
    ++tally_["accepted"];
    check("accept");
  }

  void accept_random_edits() { accept(test::random_edits(random_, *store_->model(), store_->next_node_id())); }

  void commit_what_does_not_fit() {
    auto edits = test::random_edits(random_, *store_->model(), store_->next_node_id());
    edits.emplace_back(RemoveNode{1'000'000});
    EXPECT_FALSE(store_->commit(edits, {}));
    ++tally_["refused"];
    check("a change that does not fit");
  }

  /// The operator takes a snapshot and accepts some of what it proposes, or nothing.
  void accept_proposals() {
    room_.change();
    const auto [tracked, changes] = room_.look(*store_);
    std::vector<Proposal> accepted;
    for (const auto& proposal : changes.proposals) {
      if (random_() % 4 != 0) accepted.push_back(proposal);
    }
    tally_["rejected"] += static_cast<int>(changes.proposals.size() - accepted.size());
    if (accepted.empty()) return check("rejecting all");
    const auto merged = merge_edits(*store_->model(), accepted);
    ASSERT_TRUE(merged) << merged.error().message;
    const auto before = static_cast<std::int64_t>(store_->model()->triangle_count());
    const Evidence evidence{"anna", snapshot_info(tracked, changes.registration, rig_text(room_.rig())), {}};
    const auto offered = remember_proposals(*store_, accepted);
    ASSERT_TRUE(offered) << offered.error().message;
    const auto acceptance = accept_changes(*store_, *offered, evidence);
    ASSERT_TRUE(acceptance) << acceptance.error().message;
    history_.accept(merged->edits);
    count(accepted);
    const auto& info = acceptance->info;
    EXPECT_EQ(
        before + static_cast<std::int64_t>(info.triangles_added) - static_cast<std::int64_t>(info.triangles_removed),
        static_cast<std::int64_t>(store_->model()->triangle_count()));
    check("accepting proposals");
  }

  void count(const std::vector<Proposal>& accepted) {
    ++tally_["accepted"];
    if (accepted.size() > 1) ++tally_["accepted together"];
    for (const auto& proposal : accepted) {
      tally_["inserted"] += proposal.kind == ChangeKind::insertion ? 1 : 0;
      for (const auto& removal : proposal.removed) tally_["cut"] += removal.cuts.empty() ? 0 : 1;
    }
  }

  std::filesystem::path scene_;
  std::mt19937 random_;
  ChangingRoom room_;
  Tally& tally_;
  std::unique_ptr<SceneStore> store_;
  RecordedHistory history_;
};

TEST(RandomHistories, EndBitIdenticalToTheRevisionsContent) {
  const TemporaryFolder folder;
  Tally tally = kNothing;
  for (int i = 0; i < kSequences; ++i) {
    SCOPED_TRACE(fmt::format("sequence {}", i));
    const bool measured = i % kEvery == 0;
    Sequence sequence{folder / fmt::format("{}.scene", i), static_cast<unsigned>(i), tally};
    if (measured) sequence.start_with_the_room();
    for (int steps = measured ? 16 : 30; steps > 0; --steps) {
      sequence.random_step(measured);
      if (testing::Test::HasFatalFailure()) return;
    }
    sequence.check_all_from_the_file();
    if (testing::Test::HasFatalFailure()) return;
  }
  const std::string text = fmt::format("{}", tally);
  RecordProperty("tally", text);
  for (const auto& [name, count] : tally) EXPECT_GT(count, kSequences / 10) << name << " of " << text;
}

}  // namespace
}  // namespace meshloop
