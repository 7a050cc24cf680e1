#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/simulation/sensor.h"

namespace meshloop::simulation {
namespace {

const Camera kCamera{320, 240, 290, 290, 159.5, 119.5, {}};
const Camera kSmallCamera{160, 120, 145, 145, 79.5, 59.5, {}};
const SensorModel kKinect{SensorModel::Kind::kinect1};
const SensorModel kKhoshelham{SensorModel::Kind::kinect1_khoshelham};
const SensorModel kTof{SensorModel::Kind::tof};

ExactDepth flat(double z, double theta, const Camera& camera = kCamera) {
  return {DepthImage(camera.width, camera.height, static_cast<float>(z)),
          Image<std::uint16_t>(camera.width, camera.height, 1),
          Image<float>(camera.width, camera.height, static_cast<float>(std::cos(theta)))};
}

struct Statistics {
  double mean = 0;
  double sigma = 0;
  double missing = 0;
};

Statistics statistics(const DepthImage& measured, double truth) {
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (const float z : measured.pixels()) {
    if (z == 0) continue;
    sum += z - truth;
    squares += (z - truth) * (z - truth);
    ++count;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(squares / count - mean * mean), 1 - count / static_cast<double>(measured.size())};
}

// Averages over a little range of depths, as surfaces have it: at one exact depth the sensor's steps show.
void expect_sigma_of_model(const SensorModel& sensor, double z, double theta) {
  constexpr int kDepths = 10;
  double variance = 0;
  double mean = 0;
  for (int i = 0; i < kDepths; ++i) {
    const double depth = z * (1 + 0.002 * i);
    const auto seen = statistics(
        measure(flat(depth, theta, kSmallCamera), kSmallCamera, sensor, {1, static_cast<std::uint64_t>(i) + 5}), depth);
    variance += seen.sigma * seen.sigma / kDepths;
    mean += seen.mean / kDepths;
    EXPECT_LT(seen.missing, 1e-3);
  }
  const double expected = sensor.sigma_z_m(z * 1.009, theta);
  EXPECT_NEAR(std::sqrt(variance), expected, 0.03 * expected) << sensor.name() << " z " << z << " theta " << theta;
  EXPECT_NEAR(mean, 0, 0.03 * expected) << sensor.name() << " z " << z << " theta " << theta;
}

TEST(Measure, SigmaFollowsTheModelOverDepth) {
  for (const double z : {0.6, 0.9, 1.2, 1.8, 2.5, 3.5}) {
    expect_sigma_of_model(kKinect, z, 0.2);
    expect_sigma_of_model(kKhoshelham, z, 0.2);
    expect_sigma_of_model(kTof, z, 0.2);
  }
}

TEST(Measure, SigmaFollowsTheModelOverTheAngle) {
  for (const double degrees : {0.0, 30.0, 59.0, 65.0, 72.0, 78.0}) {
    expect_sigma_of_model(kKinect, 1.0, degrees * std::numbers::pi / 180);
  }
}

TEST(Measure, KinectDeliversEqualStepsOfDisparity) {
  const DepthImage measured = measure(flat(2.0, 0), kCamera, kKinect, {1, 1});
  for (const float z : measured.pixels()) {
    if (z == 0) continue;
    const double steps = 1 / (z * 2.85e-3);
    ASSERT_NEAR(steps, std::round(steps), 2e-4);
  }
}

TEST(Measure, NeighboursAreIndependent) {
  const DepthImage measured = measure(flat(1.5, 0), kCamera, kTof, {1, 9});
  double covariance = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 1; u < kCamera.width; ++u) {
      covariance += (measured(u, v) - 1.5) * (measured(u - 1, v) - 1.5);
    }
  }
  const double sigma = kTof.sigma_z_m(1.5, 0);
  EXPECT_LT(std::abs(covariance) / static_cast<double>(measured.size()), 0.015 * sigma * sigma);
}

TEST(Measure, StrengthScalesTheNoise) {
  const double sigma = kKinect.sigma_z_m(1.2, 0);
  EXPECT_NEAR(statistics(measure(flat(1.2, 0), kCamera, kKinect, {0.5, 3}), 1.2).sigma, 0.5 * sigma, 0.04 * sigma);
}

TEST(Measure, WithoutNoiseTheExactDepthComesBack) {
  ExactDepth exact = flat(1.234567, 1.45);
  exact.depth(7, 8) = 2.5f;
  EXPECT_EQ(measure(exact, kCamera, kKinect, {0, 1}), exact.depth);
}

TEST(Measure, SameSeedSameImageOtherSeedAnother) {
  const ExactDepth exact = flat(1.2, 0);
  EXPECT_EQ(measure(exact, kCamera, kKinect, {1, 4}), measure(exact, kCamera, kKinect, {1, 4}));
  EXPECT_FALSE(measure(exact, kCamera, kKinect, {1, 4}) == measure(exact, kCamera, kKinect, {1, 5}));
}

TEST(Measure, NothingOutsideTheRangeOrBeyondEightyDegrees) {
  for (const double strength : {0.0, 1.0}) {
    EXPECT_EQ(statistics(measure(flat(0.3, 0), kCamera, kTof, {strength, 1}), 0.3).missing, 1);
    EXPECT_EQ(statistics(measure(flat(5.0, 0), kCamera, kTof, {strength, 1}), 5.0).missing, 1);
  }
  const double steep = 81 * std::numbers::pi / 180;
  EXPECT_EQ(statistics(measure(flat(1.0, steep), kCamera, kKinect, {1, 1}), 1.0).missing, 1);
}

// A plate 0.4 m in front of a wall, in the middle of the picture.
ExactDepth plate_before_wall(double near, double far) {
  ExactDepth exact = flat(far, 0);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 130; u < 190; ++u) {
      exact.depth(u, v) = static_cast<float>(near);
      exact.solid(u, v) = 2;
    }
  }
  return exact;
}

TEST(Measure, ProjectorShadowIsAsWideAsTheDisparityAndFallsOnOneSide) {
  const double near = 0.8;
  const double far = 1.6;
  const DepthImage measured = measure(plate_before_wall(near, far), kCamera, kKinect, {1, 2});
  const int width = static_cast<int>(std::lround(kCamera.fx * 0.075 * (1 / near - 1 / far)));
  int hidden = 0;
  int left = 0;
  int right = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 130 - width + 3; u < 130 - 3; ++u) hidden += measured(u, v) == 0 ? 1 : 0;
    for (int u = 60; u < 130 - width - 5; ++u) left += measured(u, v) == 0 ? 1 : 0;
    for (int u = 195; u < 260; ++u) right += measured(u, v) == 0 ? 1 : 0;
  }
  ASSERT_GT(width, 8);
  EXPECT_GT(hidden, 0.97 * (width - 6) * kCamera.height);
  EXPECT_EQ(left, 0);
  EXPECT_EQ(right, 0);
}

TEST(Measure, SilhouettesJumpBetweenTheTwoSurfacesAndNeverLieBetweenThem) {
  const DepthImage measured = measure(plate_before_wall(0.8, 1.6), kCamera, kKinect, {1, 2});
  int moved = 0;
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const float z = measured(u, v);
      if (z == 0) continue;
      ASSERT_TRUE(std::abs(z - 0.8) < 0.02 || std::abs(z - 1.6) < 0.06) << z;
      if (u >= 190 && z < 1) ++moved;
    }
  }
  // The mean reach of a normal jitter beyond an edge is sigma / sqrt(2 pi) = 0.32 pixels a row; at the first column a
  // share is lost to torn pixels.
  EXPECT_GT(moved, 0.1 * kCamera.height);
  EXPECT_LT(moved, 0.6 * kCamera.height);
}

TEST(Measure, SensorWithoutLateralNoiseKeepsSilhouettesAndHasNoShadow) {
  const DepthImage measured = measure(plate_before_wall(0.8, 1.6), kCamera, kTof, {1, 2});
  for (int v = 0; v < kCamera.height; ++v) {
    ASSERT_NEAR(measured(129, v), 1.6, 0.1);
    ASSERT_NEAR(measured(130, v), 0.8, 0.1);
  }
}

TEST(ColorNoise, HasTheSigmaAskedForAndNoBias) {
  ColorImage image(400, 300, {128, 100, 60});
  add_color_noise(image, 3, 11);
  double sum = 0;
  double squares = 0;
  for (const Rgb8& pixel : image.pixels()) {
    for (const int d : {pixel.r - 128, pixel.g - 100, pixel.b - 60}) {
      sum += d;
      squares += d * d;
    }
  }
  const double count = 3.0 * static_cast<double>(image.size());
  EXPECT_NEAR(sum / count, 0, 0.02);
  // Rounding to grey levels adds 1/12 to the variance.
  EXPECT_NEAR(std::sqrt(squares / count), std::sqrt(9 + 1.0 / 12), 0.03);
}

TEST(ColorNoise, ClampsAtBlackAndWhiteAndLeavesTheImageAloneWithoutSigma) {
  ColorImage image(64, 64, {0, 255, 1});
  const ColorImage before = image;
  add_color_noise(image, 0, 1);
  EXPECT_EQ(image, before);
  add_color_noise(image, 20, 1);
  for (const Rgb8& pixel : image.pixels()) {
    ASSERT_LT(pixel.r, 110);
    ASSERT_GT(pixel.g, 140);
  }
}

}  // namespace
}  // namespace meshloop::simulation
