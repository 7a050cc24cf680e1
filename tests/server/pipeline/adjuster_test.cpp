#include "server/pipeline/adjuster.h"

#include <gmock/gmock.h>

#include "changing_room.h"
#include "common/base/file.h"
#include "common/recording/recording.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

class AcceptChanges : public testing::Test {
 protected:
  AcceptChanges() {
    store_ = SceneStore::open(folder_ / "a.scene", true).value();
    store_->commit(room_.model_from(1), {}).value();
    room_.change();
    look_ = room_.look(*store_);
  }

  TemporaryFolder folder_;
  test::ChangingRoom room_{1};
  std::unique_ptr<SceneStore> store_;
  test::ChangingRoom::Look look_;
};

TEST_F(AcceptChanges, TheJournalSaysWhoAndWhatItWasMeasuredWith) {
  ASSERT_FALSE(look_.changes.proposals.empty());
  const TrackedPose& pose = look_.tracked.depth_pose;
  Registration registration;
  registration.T_camera_world = exp(Twist::Constant(1e-3)) * pose.T_camera_world;
  const Evidence evidence{"anna", snapshot_info(look_.tracked, registration, rig_text(room_.rig())),
                          ColorImage{4, 3, {1, 2, 3}}};
  const auto offered = remember_proposals(*store_, look_.changes.proposals).value();
  const auto acceptance = accept_changes(*store_, offered, evidence);
  ASSERT_TRUE(acceptance) << acceptance.error().message;
  const auto info = store_->log().value().back();
  EXPECT_EQ(info.revision, 2u);
  EXPECT_EQ(info.author, "anna");
  EXPECT_EQ(info.accepted_ns, acceptance->info.accepted_ns);
  EXPECT_THAT(info.summary, testing::StartsWith("proposal 1: "));
  ASSERT_EQ(info.proposals.size(), offered.size());
  EXPECT_EQ(info.proposals[0].id, 1U);
  EXPECT_EQ(info.proposals[0].content.effect, offered[0].proposal.effect);
  EXPECT_EQ(store_->proposals().value()[0].state, ProposalState::accepted);
  EXPECT_EQ(info.pictures.size(), 1u);
  ASSERT_TRUE(info.snapshot);
  EXPECT_EQ(info.snapshot->depth_pose.T_camera_world.matrix(), pose.T_camera_world.matrix());
  EXPECT_EQ(info.snapshot->depth_pose.covariance, pose.covariance);
  ASSERT_TRUE(info.snapshot->refined_T_camera_world);
  EXPECT_EQ(info.snapshot->refined_T_camera_world->matrix(), registration.T_camera_world.matrix());
  ASSERT_TRUE(write_text_file(folder_ / "rig.yaml", info.snapshot->calibration));
  EXPECT_EQ(read_rig(folder_ / "rig.yaml").value().depth.fx, room_.rig().depth.fx);
}

TEST_F(AcceptChanges, APoseThatWasNotFittedIsNotSaidToBe) {
  Registration refused;
  refused.refused = "for the test";
  EXPECT_FALSE(snapshot_info(look_.tracked, refused, "").refined_T_camera_world);
}

}  // namespace
}  // namespace meshloop
