#include "server/compare/pixel_uncertainty.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/change/classify_rule.h"
#include "compare_scene.h"

namespace meshloop {
namespace {

using namespace compare_test;

// A large plane through (0, 0, 2) with the given slopes of z by x and y.
Model slanted_plane(float by_x, float by_y) {
  const auto p = [&](float x, float y) { return Eigen::Vector3f(x, y, 2 + by_x * x + by_y * y); };
  Model model;
  add(model, quad(p(-3, -3), p(3, -3), p(3, 3), p(-3, 3)), Pose::Identity());
  return model;
}

TEST(ExpectedPlane, IsThatOfARenderedPlane) {
  const Camera camera = camera_of(160, 120);
  const auto depth = render_depth(slanted_plane(0.5F, -0.3F), camera, Pose::Identity());
  // z = 2 + x/2 - 0.3 y, so N = (-0.5, 0.3, 1) / 2.
  const Eigen::Vector3d plane = expected_plane(depth, camera, 40, 90);
  EXPECT_LT((plane - Eigen::Vector3d(-0.25, 0.15, 0.5)).norm(), 1e-3) << plane.transpose();
}

TEST(ExpectedPlane, IsNotBentByADepthEdge) {
  const Camera camera = camera_of(160, 120);
  DepthImage depth(160, 120, 2.0F);
  for (int v = 0; v < 120; ++v) {
    for (int u = 80; u < 160; ++u) depth(u, v) = 1.0F;
  }
  const Eigen::Vector3d left = expected_plane(depth, camera, 79, 60);
  const Eigen::Vector3d right = expected_plane(depth, camera, 80, 60);
  EXPECT_LT((left - Eigen::Vector3d(0, 0, 0.5)).norm(), 1e-6);
  EXPECT_LT((right - Eigen::Vector3d(0, 0, 1)).norm(), 1e-6);
}

TEST(ExpectedPlane, FacesTheCameraWhereAPixelStandsAlone) {
  const Camera camera = camera_of(16, 16);
  DepthImage depth(16, 16);
  depth(8, 8) = 4;
  EXPECT_LT((expected_plane(depth, camera, 8, 8) - Eigen::Vector3d(0, 0, 0.25)).norm(), 1e-6);
}

TEST(DepthByTwist, IsTheChangeOfRenderedDepth) {
  const Camera camera = camera_of(160, 120);
  constexpr double kStep = 1e-3;
  for (const auto& [by_x, by_y] : {std::pair{0.0F, 0.0F}, {0.8F, -0.4F}, {-1.2F, 0.6F}}) {
    const Model model = slanted_plane(by_x, by_y);
    const Pose T_depth_world = at(0.1, -0.05, 0.2, 0.1);
    const auto depth = render_depth(model, camera, T_depth_world);
    for (const auto& [u, v] : {std::pair{80, 60}, {50, 40}, {100, 85}}) {
      const Eigen::Vector3d p = camera.back_project(u, v, static_cast<double>(depth(u, v)));
      const auto J = depth_by_twist(expected_plane(depth, camera, u, v), p);
      for (int i = 0; i < 6; ++i) {
        const Twist twist = kStep * Twist::Unit(i);
        const auto more = render_depth(model, camera, exp(twist) * T_depth_world);
        const auto less = render_depth(model, camera, exp(-twist) * T_depth_world);
        const double numeric = static_cast<double>(more(u, v) - less(u, v)) / (2 * kStep);
        EXPECT_NEAR(J(i), numeric, 0.01 * std::max(1.0, std::abs(numeric)))
            << "twist " << i << " at " << u << ", " << v;
      }
    }
  }
}

// The value of parameter i of (fx, fy, cx, cy) changed.
Camera with_changed_intrinsic(Camera camera, int i, double change) {
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
    if (i-- == 0) *value += change;
  }
  return camera;
}

TEST(DepthByIntrinsics, IsTheChangeOfRenderedDepth) {
  const Camera camera = camera_of(160, 120);
  constexpr double kStep_px = 0.1;
  for (const auto& [by_x, by_y] : {std::pair{0.0F, 0.0F}, {0.8F, -0.4F}, {-1.2F, 0.6F}}) {
    const Model model = slanted_plane(by_x, by_y);
    const Pose T_depth_world = at(0.1, -0.05, 0.2, 0.1);
    const auto depth = render_depth(model, camera, T_depth_world);
    for (const auto& [u, v] : {std::pair{80, 60}, {50, 40}, {100, 85}}) {
      const Eigen::Vector3d p = camera.back_project(u, v, static_cast<double>(depth(u, v)));
      const auto J = depth_by_intrinsics(camera, expected_plane(depth, camera, u, v), p);
      for (int i = 0; i < 4; ++i) {
        const auto more = render_depth(model, with_changed_intrinsic(camera, i, kStep_px), T_depth_world);
        const auto less = render_depth(model, with_changed_intrinsic(camera, i, -kStep_px), T_depth_world);
        const double numeric = static_cast<double>(more(u, v) - less(u, v)) / (2 * kStep_px);
        EXPECT_NEAR(J(i), numeric, 0.01 * std::abs(numeric) + 1e-5) << "parameter " << i << " at " << u << ", " << v;
      }
    }
  }
}

TEST(PixelByIntrinsics, IsTheMotionOfAPoint) {
  const Camera camera = camera_of(160, 120);
  const Eigen::Vector3d p(0.3, -0.2, 1.5);
  const auto J = pixel_by_intrinsics(p);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d numeric = with_changed_intrinsic(camera, i, 1).project(p) - camera.project(p);
    EXPECT_LT((J.col(i) - numeric).norm(), 1e-9) << "parameter " << i;
  }
}

TEST(PixelByTwist, IsTheMotionOfAPoint) {
  const Camera camera = camera_of(160, 120);
  const Eigen::Vector3d p(0.3, -0.2, 1.5);
  const auto J = pixel_by_twist(camera, p);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    const Twist twist = kStep * Twist::Unit(i);
    const Eigen::Vector2d numeric = (camera.project(exp(twist) * p) - camera.project(exp(-twist) * p)) / (2 * kStep);
    EXPECT_LT((J.col(i) - numeric).norm(), 1e-4) << "twist " << i;
  }
}

TEST(ViewingAngle, IsBetweenRayAndNormal) {
  const Eigen::Vector3d p(0.5, 0, 2);
  EXPECT_NEAR(viewing_angle(p / p.squaredNorm(), p), 0, 1e-6);
  // A wall across the optical axis, seen from the side.
  EXPECT_NEAR(viewing_angle({0, 0, 0.5}, p), std::atan2(0.5, 2), 1e-9);
}

class PixelUncertaintyTest : public testing::Test {
 protected:
  PixelUncertaintyTest() {
    input_.camera = camera_of(160, 120);
    input_.sensor = *SensorModel::constant(0.002);
    input_.pose.state = TrackState::tracking;
  }
  PixelUncertainty at_centre(double measured_m) const {
    return pixel_uncertainty(input_, expected_, 80, 60, measured_m);
  }

  CompareInput input_;
  DepthImage expected_{160, 120, 2.0F};
};

TEST_F(PixelUncertaintyTest, FixedThresholdHoldsEverywhere) {
  input_.threshold = {Threshold::Kind::fixed, 0.4};
  EXPECT_EQ(at_centre(2).threshold_m, 0.4);
  EXPECT_EQ(at_centre(2).reach_px, 0);
}

TEST_F(PixelUncertaintyTest, ConstantSensorAndCertainPoseReachAsFarAsTheirPixels) {
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::hypot(0.002, 0.00012), 1e-9);
  EXPECT_EQ(at_centre(2).reach_px, 1);
}

TEST_F(PixelUncertaintyTest, KinectReachesTwoPixels) {
  input_.sensor = SensorModel{SensorModel::Kind::kinect1};
  const double sigma = 0.0012 + 0.0019 * 1.6 * 1.6;
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::hypot(sigma, 0.00012), 1e-6);
  EXPECT_EQ(at_centre(2).reach_px, 2);
}

TEST_F(PixelUncertaintyTest, FartherMeasurementCountsWithItsOwnNoise) {
  input_.sensor = SensorModel{SensorModel::Kind::tof};
  EXPECT_NEAR(at_centre(4).threshold_m, 3 * 0.04, 1e-4);
  EXPECT_NEAR(at_centre(1).threshold_m, 3 * 0.02, 1e-4);
}

TEST_F(PixelUncertaintyTest, RotationOfThePoseMovesTheReachUpToItsLimit) {
  // 10 mrad at fx = 145.6 are 1.5 pixels.
  input_.pose.covariance(4, 4) = 0.01 * 0.01;
  EXPECT_EQ(at_centre(2).reach_px, 4);
  input_.pose.covariance(4, 4) = 0.0025 * 0.0025;
  EXPECT_EQ(at_centre(2).reach_px, 1);
}

TEST_F(PixelUncertaintyTest, ModelToleranceAddsToTheVariance) {
  input_.model_sigma_m = 0.004;
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::sqrt(0.002 * 0.002 + 0.004 * 0.004 + 0.00012 * 0.00012), 1e-9);
}

TEST_F(PixelUncertaintyTest, CalibrationCountsOnSlantedSurfacesAndMovesTheReach) {
  input_.intrinsics_covariance(2, 2) = 1;  // cx to 1 pixel
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::hypot(0.002, 0.00012), 1e-9);
  EXPECT_EQ(at_centre(2).reach_px, 3);
  // Inverse depth by 0.001 a pixel: 4 mm of depth a pixel at two metres.
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) expected_(u, v) = static_cast<float>(1 / (0.5 + 0.001 * (u - 80)));
  }
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::sqrt(0.002 * 0.002 + 0.004 * 0.004 + 0.00012 * 0.00012), 2e-5);
}

TEST_F(PixelUncertaintyTest, AveragingDividesTheNoiseOfEachPixelByItsOwnCount) {
  Image<std::uint8_t> frames(160, 120, 1);
  frames(80, 60) = 16;
  input_.frames_averaged = &frames;
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::hypot(0.002 / 4, 0.00012), 1e-9);
  frames(80, 60) = 1;
  EXPECT_NEAR(at_centre(2).threshold_m, 3 * std::hypot(0.002, 0.00012), 1e-9);
  // What does not change from frame to frame stays.
  frames(80, 60) = 255;
  input_.model_sigma_m = 0.003;
  EXPECT_GT(at_centre(2).threshold_m, 3 * 0.003);
}

TEST_F(PixelUncertaintyTest, ThresholdAboveAQuarterMetreTellsNothing) {
  input_.pose.covariance(2, 2) = 0.1 * 0.1;
  EXPECT_EQ(at_centre(2).threshold_m, static_cast<double>(rule::kNoThreshold_m));
}

TEST_F(PixelUncertaintyTest, SurfaceSeenAlmostFromTheSideTellsNothing) {
  for (const double degrees : {86.0, 89.0}) {
    // A plane x = z / tan(angle) + c through the middle of the picture, as inverse depth that is linear in u.
    const double slope = std::tan(degrees * std::numbers::pi / 180) / (input_.camera.fx * 2);
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        const double inverse = 0.5 + slope * (u - input_.camera.cx);
        expected_(u, v) = inverse > 0.05 ? static_cast<float>(1 / inverse) : 0.0F;
      }
    }
    const double threshold = at_centre(2).threshold_m;
    EXPECT_EQ(threshold >= static_cast<double>(rule::kNoThreshold_m), degrees > 88) << degrees;
  }
}

TEST_F(PixelUncertaintyTest, PixelWithoutExpectedSurfaceUsesTheMeasurement) {
  expected_ = DepthImage(160, 120);
  input_.sensor = SensorModel{SensorModel::Kind::tof};
  EXPECT_NEAR(at_centre(3).threshold_m, 3 * 0.03, 1e-4);
}

}  // namespace
}  // namespace meshloop
