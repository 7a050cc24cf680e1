#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "comparator_fixture.h"

namespace meshloop {
namespace {

using namespace compare_test;

class ComparatorRefuses : public ComparatorTest {
 protected:
  void SetUp() override {
    ComparatorTest::SetUp();
    look_at(model_, 1);
  }
  std::string refusal() {
    const auto result = comparator_->compare(input_, nullptr);
    return result ? "" : result.error().message;
  }
};

TEST_F(ComparatorRefuses, DepthOfAnotherSize) {
  measured_ = DepthImage(160, 120);
  EXPECT_NE(refusal().find("160x120"), std::string::npos) << refusal();
}

TEST_F(ComparatorRefuses, PoseThatIsLost) {
  input_.pose.state = TrackState::lost;
  EXPECT_NE(refusal().find("lost"), std::string::npos);
}

TEST_F(ComparatorRefuses, PoseThatIsNotRigid) {
  input_.pose.T_camera_world.linear() *= 1.1;
  EXPECT_NE(refusal().find("rotation"), std::string::npos);
  input_.pose.T_camera_world.linear().setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(refusal().find("rotation"), std::string::npos);
}

TEST_F(ComparatorRefuses, CovarianceThatIsNotANumber) {
  input_.pose.covariance(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal().find("covariance"), std::string::npos);
}

TEST_F(ComparatorRefuses, ThresholdsThatAreNotAboveZero) {
  for (const double value :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    input_.threshold.value = value;
    EXPECT_NE(refusal().find("threshold"), std::string::npos) << value;
  }
}

TEST_F(ComparatorRefuses, CameraThatIsNotOne) {
  input_.camera.fx = 0;
  EXPECT_NE(refusal().find("camera"), std::string::npos);
}

TEST_F(ComparatorRefuses, MissingModelOrImage) {
  input_.measured = nullptr;
  EXPECT_FALSE(refusal().empty());
  input_.measured = &measured_;
  input_.model = nullptr;
  EXPECT_FALSE(refusal().empty());
}

}  // namespace
}  // namespace meshloop
