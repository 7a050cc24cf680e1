#include "common/geometry/sensor_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

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

TEST(SensorModel, MeasuredHoldsItsNearValueAndGrowsWithTheSquareBeyond) {
  SensorNoise noise;
  noise.axial = {0.001, 0.0005, 0.002};
  noise.nearest_m = 0.5;
  noise.farthest_m = 2;
  const SensorModel sensor = SensorModel::measured(noise).value();
  EXPECT_EQ(sensor.name(), "measured");
  EXPECT_NEAR(sensor.sigma_z_m(1, 0), 0.0035, 1e-12);
  EXPECT_EQ(sensor.sigma_z_m(0.1, 0), sensor.sigma_z_m(0.5, 0));
  EXPECT_NEAR(sensor.sigma_z_m(4, 0), 4 * sensor.sigma_z_m(2, 0), 1e-12);
}

TEST(SensorModel, AveragingDividesTheNoiseAndNotTheSteps) {
  const SensorModel kinect = named("kinect1");
  const double sigma = kinect.sigma_z_m(2, 0);
  const double step = kinect.quantisation_m(2);
  EXPECT_NEAR(kinect.variance_m2(2, 0, 1), sigma * sigma, 1e-15);
  EXPECT_NEAR(kinect.variance_m2(2, 0, 10), (sigma * sigma - step * step / 12) / 10 + step * step / 12, 1e-15);
  EXPECT_NEAR(named("tof").variance_m2(2, 0, 4), 0.01 * 0.01, 1e-15);
  // Never more than the sensor's own sigma, also where its steps are coarse.
  EXPECT_LE(kinect.variance_m2(20, 0, 100), kinect.sigma_z_m(20, 0) * kinect.sigma_z_m(20, 0));
}

TEST(SensorModel, ManyFrontalSigmasAreWhatEachIs) {
  std::vector<float> depths;
  for (int i = 0; i < 1000; ++i) depths.push_back(0.1F + 0.02F * static_cast<float>(i));
  for (const auto kind : {SensorModel::Kind::kinect1, SensorModel::Kind::kinect1_khoshelham, SensorModel::Kind::tof}) {
    const SensorModel model{kind};
    std::vector<float> sigmas(depths.size());
    model.frontal_sigmas_m(depths, sigmas);
    for (std::size_t i = 0; i < depths.size(); ++i)
      EXPECT_FLOAT_EQ(sigmas[i], static_cast<float>(model.sigma_z_m(depths[i], 0))) << depths[i];
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
