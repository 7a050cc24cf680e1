// Proposals of snapshots under the scene's ids.
#include "server/pipeline/proposal_book.h"

#include <gmock/gmock.h>

#include "changing_room.h"
#include "server/pipeline/decisions.h"
#include "server/pipeline/proposal_json.h"
#include "server/pipeline/result_json.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

class ProposalBook : public testing::Test {
 protected:
  ProposalBook() {
    store_ = SceneStore::open(folder_ / "a.scene", true).value();
    store_->commit(room_.model_from(1), {}).value();
    room_.change();
  }
  std::vector<Offered> look() {
    look_ = room_.look(*store_);
    return remember_proposals(*store_, look_.changes.proposals).value();
  }
  RevisionInfo accept(const std::vector<Offered>& offered) {
    const Evidence evidence{"anna", snapshot_info(look_.tracked, {}, "a rig"), {}};
    return accept_changes(*store_, offered, evidence).value().info;
  }
  static std::vector<ProposalId> ids(const std::vector<Offered>& offered) {
    std::vector<ProposalId> all;
    for (const auto& one : offered) all.push_back(one.record.id);
    return all;
  }

  TemporaryFolder folder_;
  test::ChangingRoom room_{1};
  std::unique_ptr<SceneStore> store_;
  test::ChangingRoom::Look look_;
};

TEST_F(ProposalBook, TheSameThingHasTheSameIdInEachSnapshot) {
  const auto first = look();
  ASSERT_FALSE(first.empty());
  EXPECT_EQ(first[0].record.id, 1u);
  EXPECT_EQ(first[0].proposal.id, 1u) << "what speaks of it from here on speaks to people";
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ids(look()), ids(first));
  store_.reset();
  store_ = SceneStore::open(folder_ / "a.scene", false).value();
  EXPECT_EQ(ids(look()), ids(first)) << "in another run too";
}

TEST_F(ProposalBook, UndoOpensItUnderItsIdAndWhatWasAcceptedStaysClosed) {
  const auto first = look();
  ASSERT_FALSE(first.empty());
  const auto info = accept(first);
  EXPECT_EQ(info.proposals.size(), first.size());
  for (const auto& left : look()) EXPECT_THAT(ids(first), testing::Not(testing::Contains(left.record.id)));
  Decisions again;
  again.accept = {1};
  const auto refused = chosen(again, look(), store_->proposals().value());
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("proposal 1 was accepted by revision 2, by anna at 20"));
  store_->undo("bert").value();
  const auto reopened = look();
  EXPECT_EQ(ids(reopened), ids(first));
  EXPECT_TRUE(reopened[0].record.was_undone());
  EXPECT_THAT(decision_text(reopened[0].record), HasSubstr("revision 2 was undone by bert"));
}

TEST_F(ProposalBook, WithoutWritingWhatIsNewHasNoId) {
  look_ = room_.look(*store_);
  const auto unknown = recognise_proposals(*store_, look_.changes.proposals).value();
  ASSERT_FALSE(unknown.empty());
  EXPECT_EQ(unknown[0].record.id, 0u);
  EXPECT_TRUE(proposal_json(unknown[0])["id"].is_null());
  EXPECT_TRUE(store_->proposals().value().empty());
  const auto known = look();
  EXPECT_EQ(ids(recognise_proposals(*store_, look_.changes.proposals).value()), ids(known));
}

TEST_F(ProposalBook, WhatWasRejectedIsLeftOutOfAll) {
  const auto first = look();
  ASSERT_FALSE(first.empty());
  Decisions decisions;
  decisions.reject = {1, 77};
  decisions.reason = "a toy";
  ASSERT_TRUE(reject_known(*store_, "anna", decisions));
  EXPECT_THAT(decisions.reject, testing::ElementsAre(77)) << "it may turn up later";
  EXPECT_THAT(check_all_rejected(decisions).error().message, HasSubstr("no proposal 77"));
  Decisions all;
  all.accept_all = true;
  const auto accepted = chosen(all, look(), store_->proposals().value()).value();
  EXPECT_EQ(accepted.size(), first.size() - 1);
  EXPECT_THAT(ids(accepted), testing::Not(testing::Contains(1)));
  Decisions by_id;
  by_id.accept = {1};
  EXPECT_EQ(chosen(by_id, look(), store_->proposals().value()).value().size(), 1u) << "the operator may think again";
}

TEST_F(ProposalBook, TheJournalHasWhatWasAccepted) {
  const auto offered = look();
  ASSERT_FALSE(offered.empty());
  accept(offered);
  const auto json = revision_json(store_->log().value().back());
  ASSERT_EQ(json["proposals"].size(), offered.size());
  const auto& entry = json["proposals"][0];
  EXPECT_EQ(entry["id"], 1);
  EXPECT_EQ(entry["kind"], std::string{name_of(offered[0].record.content.kind)});
  EXPECT_EQ(entry["confidence"], offered[0].proposal.confidence);
  EXPECT_EQ(entry["box_m"]["min"][0], offered[0].proposal.box_m.min().x());
  EXPECT_EQ(entry["T_world_new_old"].is_null(), !offered[0].proposal.move.has_value());
}

TEST(Decisions, AreReadFromLists) {
  EXPECT_THAT(parse_proposal_ids("3,1").value(), testing::ElementsAre(1, 3));
  EXPECT_THAT(parse_proposal_ids(" 1 ,\t3-4 , 7").value(), testing::ElementsAre(1, 3, 4, 7));
  for (const char* wrong : {"", " ", "0", "0,1", "a", "1,", "1, ", ", 1", "1,,2", "1 3", "-1", "1.5"}) {
    const auto ids = parse_proposal_ids(wrong);
    ASSERT_FALSE(ids) << wrong;
    EXPECT_EQ(ids.error().kind, ErrorKind::usage) << wrong;
  }
  Decisions decisions;
  ASSERT_TRUE(parse_accept("", "--accept", decisions));
  EXPECT_TRUE(!decisions.accept_all && decisions.accept.empty());
  ASSERT_TRUE(parse_accept("all", "--accept", decisions));
  EXPECT_TRUE(decisions.accept_all);
  EXPECT_FALSE(parse_accept("most", "--accept", decisions));
}

}  // namespace
}  // namespace meshloop
