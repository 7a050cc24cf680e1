#include "server/pipeline/pose_trust.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace meshloop {
namespace {

using ::testing::HasSubstr;

TEST(PoseTrust, IsThereUntilItIsLost) {
  PoseTrust trust;
  EXPECT_FALSE(trust.doubt());
  EXPECT_FALSE(trust.regain());
}

TEST(PoseTrust, ComesBackAfterFiveGoodFrames) {
  PoseTrust trust;
  trust.lose();
  EXPECT_THAT(trust.doubt().value(), HasSubstr("5 more frames"));
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(trust.regain());
  EXPECT_THAT(trust.doubt().value(), HasSubstr("1 more frame must"));
  EXPECT_TRUE(trust.regain());
  EXPECT_FALSE(trust.doubt());
  EXPECT_FALSE(trust.regain());
}

TEST(PoseTrust, CountsAnewAfterEachBadFrame) {
  PoseTrust trust;
  trust.lose();
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(trust.regain());
  trust.lose();
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(trust.regain());
  EXPECT_FALSE(trust.regain());
}

TEST(PoseTrust, SaysWhyNothingIsProposed) {
  PoseTrust trust;
  EXPECT_EQ(trust.why_nothing_is_proposed(), "nothing is proposed now");
  trust.lose();
  EXPECT_THAT(trust.why_nothing_is_proposed(), HasSubstr(trust.doubt().value()));
}

}  // namespace
}  // namespace meshloop
