// What a scene remembers of proposals.
#include <gmock/gmock.h>
#include <sqlite3.h>

#include "scenes.h"

namespace meshloop {
namespace {

using test::add;
using test::open_or_die;
using testing::HasSubstr;

ProposalContent content_at(double x, ProposalKind kind = ProposalKind::insertion) {
  ProposalContent content;
  content.kind = kind;
  content.nodes = {7, 9};
  content.box_m.extend(Eigen::Vector3d{x, 0, 1.0 / 3});
  content.box_m.extend(Eigen::Vector3d{x + 0.2, 0.1, 1});
  content.effect = "+96 triangles; largest change 21 mm";
  content.confidence = 0.97;
  content.largest_change_m = 0.021;
  return content;
}

ProposalSighting seen(double x) {
  return {std::nullopt, std::nullopt, content_at(x)};
}

RevisionInfo accepting(ProposalId id, double x = 0) {
  RevisionInfo info;
  info.author = "anna";
  info.proposals = {{id, content_at(x)}};
  return info;
}

class Proposals : public test::SceneFolder {
 protected:
  Proposals() : store_{open_or_die(scene_)} {}
  ProposalRecord record(ProposalId id) const { return store_->proposals().value().at(id - 1); }
  void reopen() {
    store_.reset();
    store_ = open_or_die(scene_, false);
  }
  void run_sql(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(scene_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }

  std::unique_ptr<SceneStore> store_;
};

TEST_F(Proposals, ComeBackAsTheyWereTold) {
  ProposalSighting sighting = seen(1);
  sighting.content.kind = ProposalKind::move;
  sighting.content.T_world_new_old =
      make_pose({0.1, 0.2, 0.3}, Eigen::Quaterniond{Eigen::AngleAxisd{0.5, Eigen::Vector3d::UnitZ()}});
  EXPECT_THAT(store_->remember({sighting, seen(5)}).value(), testing::ElementsAre(1, 2));
  reopen();
  const auto read = record(1);
  EXPECT_EQ(read.content.kind, ProposalKind::move);
  EXPECT_EQ(read.content.nodes, sighting.content.nodes);
  EXPECT_EQ(read.content.box_m.min(), sighting.content.box_m.min());
  EXPECT_EQ(read.content.box_m.max(), sighting.content.box_m.max());
  EXPECT_EQ(read.content.effect, sighting.content.effect);
  EXPECT_EQ(read.content.confidence, 0.97);
  EXPECT_EQ(read.content.largest_change_m, 0.021);
  ASSERT_TRUE(read.content.T_world_new_old);
  EXPECT_EQ(read.content.T_world_new_old->matrix(), sighting.content.T_world_new_old->matrix());
  EXPECT_EQ(read.state, ProposalState::open);
  EXPECT_GT(read.first_seen_ns, 0);
  EXPECT_FALSE(read.revision || read.was_undone());
}

TEST_F(Proposals, AreAcceptedInTheRevisionsOwnTransaction) {
  store_->remember({seen(0), seen(5)}).value();
  EXPECT_EQ(store_->commit({add(1, 1)}, accepting(1)).value()->revision, 1u);
  EXPECT_EQ(record(1).state, ProposalState::accepted);
  EXPECT_EQ(record(1).revision, 1u);
  EXPECT_EQ(record(1).author, "anna");
  EXPECT_EQ(record(2).state, ProposalState::open);
  const auto again = store_->commit({add(2, 2)}, accepting(1));
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message, HasSubstr("proposal 1 was accepted by revision 1"));
  const auto unknown = store_->commit({add(2, 2)}, accepting(9));
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("no proposal 9"));
  RevisionInfo one_is_wrong = accepting(2);
  one_is_wrong.proposals.push_back({1, content_at(0)});
  EXPECT_FALSE(store_->commit({add(2, 2)}, one_is_wrong));
  EXPECT_EQ(store_->model()->revision, 1u);
  EXPECT_EQ(record(2).state, ProposalState::open) << "nothing of a refused change stays";
  reopen();
  EXPECT_EQ(store_->model()->revision, 1u);
  EXPECT_EQ(store_->log().value().at(0).proposals.at(0).id, 1u);
}

TEST_F(Proposals, AreOpenAgainAfterUndoAndAcceptedAgainAfterRedo) {
  store_->commit({add(1, 1)}, {}).value();
  store_->remember({seen(0), seen(5)}).value();
  store_->commit({add(2, 2)}, accepting(1)).value();
  const auto accepted_ns = record(1).decided_ns;
  store_->commit({add(3, 3)}, accepting(2, 5)).value();
  store_->undo("bert").value();
  EXPECT_EQ(record(1).state, ProposalState::accepted) << "only the last change is taken back";
  EXPECT_TRUE(record(2).was_undone());
  EXPECT_EQ(record(2).author, "bert");
  store_->undo("bert").value();
  EXPECT_TRUE(record(1).was_undone());
  store_->redo("carl").value();
  EXPECT_EQ(record(1).state, ProposalState::accepted);
  EXPECT_EQ(record(1).revision, 2u);
  EXPECT_EQ(record(1).author, "anna") << "revision 2 is hers; the journal has the redo";
  EXPECT_EQ(record(1).decided_ns, accepted_ns);
  EXPECT_TRUE(record(2).was_undone());
  reopen();
  EXPECT_EQ(store_->commit({add(4, 4)}, accepting(2, 5)).value()->revision, 7u);
  EXPECT_EQ(record(2).revision, 7u) << "what was undone can be accepted, by another revision";
  const auto log = store_->log().value();
  EXPECT_EQ(log.at(2).proposals.at(0).id, 2u) << "the journal still says what happened then";
  EXPECT_EQ(log.at(6).proposals.at(0).id, 2u);
  EXPECT_TRUE(log.at(3).proposals.empty());
}

TEST_F(Proposals, ThatWereRejectedAreNotAcceptedByRedo) {
  store_->remember({seen(0), seen(5)}).value();
  RevisionInfo both = accepting(1);
  both.proposals.push_back({2, content_at(5)});
  store_->commit({add(1, 1)}, both).value();
  store_->undo("bert").value();
  ASSERT_TRUE(store_->reject({2}, "carl", "a toy"));
  const auto redone = store_->redo("bert");
  ASSERT_FALSE(redone);
  EXPECT_THAT(redone.error().message, HasSubstr("proposal 2, which was rejected by carl"));
  reopen();
  EXPECT_EQ(store_->model()->revision, 2u) << "nothing of the redo stays";
  EXPECT_TRUE(record(1).was_undone());
  EXPECT_EQ(record(2).state, ProposalState::rejected);
  EXPECT_EQ(record(2).reason, "a toy");
  EXPECT_EQ(store_->commit({add(2, 2)}, accepting(2, 5)).value()->revision, 3u) << "by its id it can be";
}

TEST_F(Proposals, StayAsTheyAreWhenARevisionIsRestored) {
  store_->commit({add(1, 1)}, {}).value();
  store_->remember({seen(0)}).value();
  store_->commit({add(2, 2)}, accepting(1)).value();
  store_->restore(1, "anna").value();
  EXPECT_EQ(record(1).state, ProposalState::accepted);
  store_->undo("anna").value();
  EXPECT_EQ(record(1).state, ProposalState::accepted) << "undone was the restoring, not the change";
  store_->undo("anna").value();
  EXPECT_TRUE(record(1).was_undone());
}

TEST_F(Proposals, KeepWhatWasRejectedWhereverTheyAreSeenLater) {
  store_->remember({seen(0), seen(5)}).value();
  ASSERT_TRUE(store_->reject({1}, "anna", "a toy"));
  ProposalSighting later = seen(0.05);
  later.known = 1;
  ProposalSighting open = seen(5.05);
  open.known = 2;
  ProposalSighting piece = seen(0.1);
  piece.piece_of_rejected = 1;
  EXPECT_THAT(store_->remember({later, open, piece}).value(), testing::ElementsAre(1, 2, 3));
  EXPECT_EQ(record(1).content.box_m.min().x(), 0) << "or it could creep away";
  EXPECT_GE(record(1).last_seen_ns, record(1).first_seen_ns);
  EXPECT_EQ(record(1).reason, "a toy");
  EXPECT_EQ(record(2).content.box_m.min().x(), 5.05);
  EXPECT_EQ(record(3).state, ProposalState::rejected);
  EXPECT_EQ(record(3).author, "anna");
  EXPECT_EQ(record(3).reason, "a piece of proposal 1");
  EXPECT_EQ(store_->commit({add(1, 1)}, accepting(1)).value()->revision, 1u) << "the operator may think again";
  EXPECT_EQ(record(1).state, ProposalState::accepted);
}

TEST_F(Proposals, ThatAreAcceptedAreShownAsTheyWereAccepted) {
  store_->remember({seen(0)}).value();
  ASSERT_TRUE(store_->reject({1}, "anna", "a toy"));
  RevisionInfo info = accepting(1, 0.05);
  info.proposals[0].content.effect = "+50 triangles; largest change 292 mm";
  info.proposals[0].content.largest_change_m = 0.292;
  store_->commit({add(1, 1)}, info).value();
  reopen();
  EXPECT_EQ(record(1).content.effect, "+50 triangles; largest change 292 mm");
  EXPECT_EQ(record(1).content.largest_change_m, 0.292);
  EXPECT_EQ(record(1).content.box_m.min().x(), 0.05);
  store_->undo("anna").value();
  EXPECT_EQ(record(1).content.box_m.min().x(), 0) << "it is recognised by what it was before";
}

TEST_F(Proposals, RefuseDecisionsThatCannotBe) {
  store_->remember({seen(0), seen(5)}).value();
  store_->commit({add(1, 1)}, accepting(1)).value();
  const auto both = store_->reject({2, 1}, "anna", "");
  ASSERT_FALSE(both);
  EXPECT_THAT(both.error().message, HasSubstr("accepted by revision 1"));
  EXPECT_EQ(record(2).state, ProposalState::open) << "all or none";
  EXPECT_FALSE(store_->reject({3}, "anna", ""));
  ProposalSighting nowhere = seen(0);
  nowhere.content.box_m.setEmpty();
  EXPECT_FALSE(store_->remember({seen(9), nowhere}));
  ProposalSighting closed = seen(0);
  closed.known = 1;
  EXPECT_FALSE(store_->remember({seen(9), closed}));
  EXPECT_EQ(store_->proposals().value().size(), 2u);
  EXPECT_THAT(store_->remember({seen(9)}).value(), testing::ElementsAre(3)) << "no id is lost by what was refused";
}

TEST_F(Proposals, AreGivenNoIdTwiceEvenWhenRowsAreGone) {
  store_->remember({seen(0), seen(5)}).value();
  store_.reset();
  run_sql("DELETE FROM proposal WHERE proposal_id = 2");
  reopen();
  EXPECT_THAT(store_->remember({seen(9)}).value(), testing::ElementsAre(3));
}

TEST_F(Proposals, ThatAreDamagedAreSaidToBe) {
  store_->remember({seen(0)}).value();
  store_->commit({add(1, 1)}, accepting(1)).value();
  store_.reset();
  const std::string whole = test::content_of(scene_);
  const std::string infinite = "UPDATE proposal SET box = x'000000000000f07f" + std::string(80, '0') + "'";
  for (const std::string& sql :
       {std::string{"UPDATE proposal SET kind = 3"}, std::string{"UPDATE proposal SET state = -1"},
        std::string{"UPDATE proposal SET revision = NULL"}, std::string{"UPDATE proposal SET box = zeroblob(40)"},
        std::string{"UPDATE proposal SET nodes = x'00'"}, std::string{"UPDATE proposal SET transform = zeroblob(128)"},
        infinite}) {
    test::write_content(scene_, whole);
    run_sql(sql);
    store_ = open_or_die(scene_, false);
    EXPECT_EQ(store_->model()->nodes.size(), 1u) << "the model is read without";
    const auto records = store_->proposals();
    ASSERT_FALSE(records) << sql;
    EXPECT_THAT(records.error().message, HasSubstr("damaged")) << sql;
    store_.reset();
  }
  test::write_content(scene_, whole);
  run_sql("UPDATE accepted_proposal SET kind = 77");
  store_ = open_or_die(scene_, false);
  EXPECT_FALSE(store_->log());
}

}  // namespace
}  // namespace meshloop
