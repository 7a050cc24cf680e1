#include "server/calibrate/noise_measurement.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>

#include "common/simulation/sensor.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

const Camera kCamera{320, 240, 290, 290, 159.5, 119.5, {}};

// A floor that runs away from the camera, and posts before it: depths from 0.8 to 3 m, and depth edges.
simulation::Scene room() {
  simulation::Scene scene;
  const auto add = [&](const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double turn) {
    simulation::Solid solid;
    solid.name = solid.object = "solid";
    solid.size = size;
    solid.T_world_solid.translation() = centre;
    solid.T_world_solid.linear() = Eigen::AngleAxisd{turn, Eigen::Vector3d::UnitX()}.toRotationMatrix();
    solid.texture = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Rgb8{99, 99, 99}; };
    scene.solids.push_back(solid);
  };
  add({0, 0, 1.9}, {4, 4, 0.02}, 0.9);
  for (const double x : {-0.5, -0.2, 0.2, 0.5}) add({x, -0.3, 1.6}, {0.1, 0.9, 0.05}, 0);
  return scene;
}

class NoiseMeasurementTest : public testing::Test {
 protected:
  // `drift_m`: how far the camera comes nearer from frame to frame.
  void record(int frames, const SensorModel& sensor, double drift_m = 0) {
    const auto scene = room();
    Pose T_camera_world = Pose::Identity();
    auto exact = simulation::cast_depth(scene, kCamera, T_camera_world, false);
    for (int i = 0; i < frames; ++i) {
      if (drift_m != 0) {
        T_camera_world.translation().z() = -drift_m * i;
        exact = simulation::cast_depth(scene, kCamera, T_camera_world, false);
      }
      ASSERT_TRUE(
          measurement_.add(simulation::measure(exact, kCamera, sensor, {1, static_cast<std::uint64_t>(i) + 1})));
    }
  }
  NoiseMeasurement measurement_{kCamera};
};

TEST_F(NoiseMeasurementTest, FindsTheSigmaThatTheSimulatorDraws) {
  const SensorModel kinect{SensorModel::Kind::kinect1};
  record(60, kinect);
  const auto noise = measurement_.fit();
  ASSERT_TRUE(noise) << noise.error().message;
  EXPECT_LT(noise->model.noise().nearest_m, 1.3);
  EXPECT_GT(noise->model.noise().farthest_m, 2.2);
  for (double z = noise->model.noise().nearest_m; z < noise->model.noise().farthest_m; z += 0.1) {
    const double truth = kinect.sigma_z_m(z, 0);
    EXPECT_NEAR(noise->model.sigma_z_m(z, 0), truth, 0.05 * truth) << z;
  }
  EXPECT_LT(noise->worst_fit, 0.1);
  // Steps of a Kinect, from the depths that were delivered.
  EXPECT_NEAR(noise->model.noise().step_per_m, 2.85e-3, 2e-4);
  EXPECT_GT(noise->edges, NoiseMeasurement::kLeastEdges);
  EXPECT_NEAR(noise->model.noise().lateral_px, 0.8, 0.12);
  std::printf("lateral %.3f px at %zu edges, step %.2e, worst fit %.3f\n", noise->model.noise().lateral_px,
              noise->edges, noise->model.noise().step_per_m, noise->worst_fit);
}

TEST_F(NoiseMeasurementTest, SensorWithoutStepsHasNoneWorthAName) {
  const SensorModel tof{SensorModel::Kind::tof};
  record(40, tof);
  const auto noise = measurement_.fit();
  ASSERT_TRUE(noise) << noise.error().message;
  EXPECT_NEAR(noise->model.sigma_z_m(1.5, 0), 0.015, 0.0008);
  EXPECT_LT(noise->model.noise().step_per_m, 1e-4);
}

TEST_F(NoiseMeasurementTest, SceneThatMovesIsRefused) {
  record(30, SensorModel{SensorModel::Kind::kinect1}, 0.001);
  const auto noise = measurement_.fit();
  ASSERT_FALSE(noise);
  EXPECT_THAT(noise.error().message, HasSubstr("moved"));
}

TEST_F(NoiseMeasurementTest, TooFewFramesAndTooLittleSurfaceAreRefused) {
  record(19, SensorModel{SensorModel::Kind::kinect1});
  EXPECT_THAT(measurement_.fit().error().message, HasSubstr("at least 20"));
  NoiseMeasurement empty{kCamera};
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(empty.add(DepthImage(320, 240)));
  EXPECT_THAT(empty.fit().error().message, HasSubstr("too little smooth surface"));
  EXPECT_FALSE(empty.add(DepthImage(32, 24)));
}

TEST_F(NoiseMeasurementTest, NoiseBelowTheStepsCountsAsTheSteps) {
  // Always the same number: a sensor at rest whose steps of 4 mm are coarser than its noise.
  DepthImage slanted(320, 240);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u)
      slanted(u, v) = 0.004F * std::round((1.5F + 0.0004F * static_cast<float>(u)) / 0.004F);
  }
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(measurement_.add(slanted));
  const auto noise = measurement_.fit();
  ASSERT_TRUE(noise) << noise.error().message;
  EXPECT_NEAR(noise->model.sigma_z_m(1.56, 0), 0.004 / std::sqrt(12), 1e-5);
}

}  // namespace
}  // namespace meshloop
