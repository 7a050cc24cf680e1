#include "server/pipeline/change_tally.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace meshloop {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const PoseObjection kBeside{PoseGate::registration, "the pose lies 50 mm beside: check the markers' file"};
const PoseObjection kBesideMore{PoseGate::registration, "the pose lies 70 mm beside: check the markers' file"};
const PoseObjection kRinged{PoseGate::rings, "outlines are ringed: check the calibration"};

TEST(ChangeTally, OfNothingHasNoReason) {
  const ChangeTally tally;
  EXPECT_FALSE(tally.is_all_withheld());
  EXPECT_EQ(tally.json(),
            (nlohmann::json{{"confirmed", 0}, {"waiting", 0}, {"looked_at", 0}, {"withheld", 0}, {"reason", nullptr}}));
  EXPECT_EQ(tally.why_withheld(), "");
}

TEST(ChangeTally, GivesTheReasonOfTheGateThatClosedMostOften) {
  ChangeTally tally;
  for (int i = 0; i < 6; ++i) tally.add_confirmed();
  tally.add_waiting();
  tally.add_withheld(3, kRinged);
  tally.add_withheld(4, kBeside);
  tally.add_withheld(5, kBesideMore);
  tally.add_distrusted();
  EXPECT_TRUE(tally.is_all_withheld());
  EXPECT_EQ(tally.json(),
            (nlohmann::json{
                {"confirmed", 6}, {"waiting", 1}, {"looked_at", 4}, {"withheld", 4}, {"reason", kBeside.reason}}));
  EXPECT_THAT(tally.why_withheld(),
              AllOf(HasSubstr("4 frames with confirmed changes were withheld"), HasSubstr("2 of them"),
                    HasSubstr("frame 4: the pose lies 50 mm"), HasSubstr("markers' file")));
}

TEST(ChangeTally, IsNotAllWithheldWhereOneFrameWasUsable) {
  ChangeTally tally;
  tally.add_withheld(3, kBeside);
  EXPECT_TRUE(tally.is_all_withheld());
  tally.add_usable();
  EXPECT_FALSE(tally.is_all_withheld());
  EXPECT_THAT(tally.why_withheld(), HasSubstr("1 frame with confirmed changes was withheld"));
}

TEST(ChangeTally, DoesNotBlameARunForOneFrame) {
  ChangeTally tally;
  tally.add_withheld(3, kBeside);
  EXPECT_TRUE(tally.is_all_withheld());
  for (int i = 0; i < 5; ++i) tally.add_distrusted();
  EXPECT_FALSE(tally.is_all_withheld());
}

TEST(ChangeTally, OfFramesThatWaitedBlamesNoPose) {
  ChangeTally tally;
  tally.add_confirmed();
  tally.add_waiting();
  EXPECT_FALSE(tally.is_all_withheld());
}

}  // namespace
}  // namespace meshloop
