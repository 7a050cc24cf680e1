#include "common/geometry/sensor_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace meshloop {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

SensorModel named(const char* name) {
  return SensorModel::from_name(name).value();
}

TEST(SensorModel, KinectFollowsNguyen) {
  const SensorModel kinect = named("kinect1");
  EXPECT_NEAR(kinect.sigma_z_m(0.4, 0), 0.0012, 1e-15);
  EXPECT_NEAR(kinect.sigma_z_m(2.0, 0), 0.0012 + 0.0019 * 1.6 * 1.6, 1e-15);
  EXPECT_EQ(kinect.sigma_z_m(2.0, 59 * kDegree), kinect.sigma_z_m(2.0, 0));
  const double ratio = 70.0 / 20.0;
  EXPECT_NEAR(kinect.sigma_z_m(2.0, 70 * kDegree),
              0.0012 + 0.0019 * 1.6 * 1.6 + 0.0001 / std::sqrt(2.0) * ratio * ratio, 1e-12);
  EXPECT_NEAR(kinect.sigma_lateral_px(45 * kDegree), 0.8 + 0.035, 1e-12);
}

TEST(SensorModel, KinectStaysFiniteAtGrazingViewsAndNearRange) {
  const SensorModel kinect = named("kinect1");
  for (const double theta : {80 * kDegree, 89.999 * kDegree, 90 * kDegree, -1.0}) {
    EXPECT_TRUE(std::isfinite(kinect.sigma_z_m(0, theta)));
    EXPECT_GT(kinect.sigma_z_m(0, theta), 0);
    EXPECT_TRUE(std::isfinite(kinect.sigma_lateral_px(theta)));
  }
}

TEST(SensorModel, KhoshelhamGrowsWithTheSquareOfDepth) {
  const SensorModel kinect = named("kinect1-khoshelham");
  EXPECT_NEAR(kinect.sigma_z_m(3, 1), 1.425e-3 * 9, 1e-15);
  EXPECT_NEAR(kinect.quantisation_m(3), 2.85e-3 * 9, 1e-15);
  EXPECT_EQ(kinect.sigma_lateral_px(1), 0);
}

TEST(SensorModel, TimeOfFlightIsOnePercent) {
  const SensorModel tof = named("tof");
  EXPECT_NEAR(tof.sigma_z_m(2.5, 0), 0.025, 1e-15);
  EXPECT_EQ(tof.quantisation_m(2.5), 0);
}

TEST(SensorModel, ConstantIsTheSameEverywhereAndBounded) {
  const SensorModel sensor = SensorModel::constant(0.002).value();
  EXPECT_EQ(sensor.sigma_z_m(0.5, 0), 0.002);
  EXPECT_EQ(sensor.sigma_z_m(5, 1.5), 0.002);
  for (const double bad : {0.0, -0.1, 1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(SensorModel::constant(bad)) << bad;
  }
}

TEST(SensorModel, NamesLeadBackToTheModel) {
  for (const char* name : {"kinect1", "kinect1-khoshelham", "tof"}) EXPECT_EQ(named(name).name(), name);
  const auto unknown = SensorModel::from_name("kinect2");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, testing::HasSubstr("kinect1-khoshelham"));
}

}  // namespace
}  // namespace meshloop
