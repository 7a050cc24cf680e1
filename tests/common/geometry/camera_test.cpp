#include "common/geometry/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/geometry/rig.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

Camera kinect() {
  return {640, 480, 585, 586, 319.5, 239.5, {}};
}

Rig kinect_rig() {
  Rig rig;
  rig.color = kinect();
  rig.depth = kinect();
  return rig;
}

TEST(Camera, BackProjectionUndoesProjection) {
  const Camera camera = kinect();
  const Eigen::Vector3d p{0.3, -0.2, 1.7};
  const Eigen::Vector2d pixel = camera.project(p);
  EXPECT_NEAR(pixel.x(), 319.5 + 585 * 0.3 / 1.7, 1e-12);
  EXPECT_TRUE(camera.back_project(pixel.x(), pixel.y(), 1.7).isApprox(p, 1e-14));
}

TEST(Camera, DistortsByTheBrownConradyFormula) {
  Camera camera = kinect();
  camera.distortion = {0.1, -0.2, 0.001, -0.002, 0.05};
  const double x = 0.3;
  const double y = -0.2;
  const double r2 = x * x + y * y;
  const double radial = 1 + 0.1 * r2 - 0.2 * std::pow(r2, 2) + 0.05 * std::pow(r2, 3);
  const double xd = x * radial + 2 * 0.001 * x * y - 0.002 * (r2 + 2 * x * x);
  const double yd = y * radial + 0.001 * (r2 + 2 * y * y) + 2 * -0.002 * x * y;
  const Eigen::Vector2d distorted = camera.distort(camera.project({x, y, 1}));
  EXPECT_NEAR(distorted.x(), 585 * xd + 319.5, 1e-9);
  EXPECT_NEAR(distorted.y(), 586 * yd + 239.5, 1e-9);
}

// As OpenCV's documentation writes it, term by term.
TEST(Camera, ARationalLensDividesByItsLastThreeCoefficients) {
  Camera camera = kinect();
  camera.distortion = {0.6, 0.3, 0.0005, -0.0004, 0.05, 0.9, 0.4, 0.1};
  const double x = -0.4;
  const double y = 0.25;
  const double r2 = x * x + y * y;
  const double radial =
      (1 + 0.6 * r2 + 0.3 * r2 * r2 + 0.05 * r2 * r2 * r2) / (1 + 0.9 * r2 + 0.4 * r2 * r2 + 0.1 * r2 * r2 * r2);
  const double xd = x * radial + 2 * 0.0005 * x * y - 0.0004 * (r2 + 2 * x * x);
  const double yd = y * radial + 0.0005 * (r2 + 2 * y * y) - 2 * 0.0004 * x * y;
  const Eigen::Vector2d distorted = camera.distort(camera.project({x, y, 1}));
  EXPECT_NEAR(distorted.x(), 585 * xd + 319.5, 1e-9);
  EXPECT_NEAR(distorted.y(), 586 * yd + 239.5, 1e-9);
}

TEST(Camera, TheLensEndsWhereItsFormulaTurnsBack) {
  Camera camera = kinect();
  EXPECT_TRUE(std::isinf(camera.lens_limit()));
  camera.distortion[0] = 0.3;  // pulls outwards for ever
  EXPECT_TRUE(std::isinf(camera.lens_limit()));
  camera.distortion[0] = -0.8;  // r - 0.8 r^3 is steepest at its end: 1 / sqrt(2.4)
  EXPECT_NEAR(camera.lens_limit(), 1 / std::sqrt(2.4), 0.003);
  EXPECT_TRUE(validate(camera));  // beyond the nearest edge of the picture
  camera.distortion[0] = -3;
  EXPECT_THAT(validate(camera).error().message, HasSubstr("folds the picture over 130 pixels"));
  camera.distortion = {1e300, -1e300, 1e308, 1e308, 1e308};
  EXPECT_FALSE(validate(camera));
  camera.distortion = {0, 0, 0, 0, 0, -9, 0, 0};  // a pole within the picture
  EXPECT_FALSE(validate(camera));
}

TEST(Camera, ALensWithoutDistortionMovesNothing) {
  const Camera camera = kinect();
  EXPECT_FALSE(camera.has_distortion());
  EXPECT_TRUE(camera.distort({17, 400}).isApprox(Eigen::Vector2d{17, 400}, 1e-14));
  Camera bent = camera;
  bent.distortion[7] = 1e-9;
  EXPECT_TRUE(bent.has_distortion());
  EXPECT_FALSE(bent.without_distortion().has_distortion());
  EXPECT_EQ(bent.without_distortion().fy, 586);
}

TEST(Camera, ThePictureReachesHalfAPixelAroundTheOuterCentres) {
  const Camera camera = kinect();
  EXPECT_TRUE(camera.contains({-0.5, -0.5}));
  EXPECT_FALSE(camera.contains({-0.51, 10}));
  EXPECT_TRUE(camera.contains({639.49, 479.49}));
  EXPECT_FALSE(camera.contains({639.5, 10}));
  EXPECT_FALSE(camera.contains({10, 10}, 11));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(camera.contains({nan, 10}));
}

TEST(Camera, ValidationNamesWhatIsWrong) {
  EXPECT_TRUE(validate(kinect()));
  Camera camera = kinect();
  camera.width = 15;
  EXPECT_THAT(validate(camera).error().message, HasSubstr("15x480"));
  camera.width = 8193;
  EXPECT_FALSE(validate(camera));
  camera = kinect();
  camera.fx = -1;
  EXPECT_THAT(validate(camera).error().message, HasSubstr("fx"));
  camera = kinect();
  camera.distortion[3] = std::numeric_limits<double>::infinity();
  EXPECT_THAT(validate(camera).error().message, HasSubstr("finite"));
}

TEST(Rig, ValidationNamesTheCameraOrTheKey) {
  Rig rig = kinect_rig();
  EXPECT_TRUE(validate(rig));
  rig.depth.fy = 0;
  EXPECT_THAT(validate(rig).error().message, HasSubstr("depth: "));
  rig = kinect_rig();
  rig.depth_scale = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(validate(rig).error().message, HasSubstr("depth_scale"));
  rig.depth_scale = 5000;
  EXPECT_THAT(validate(rig).error().message, HasSubstr("say 0.0002"));
  rig = kinect_rig();
  rig.T_depth_color.linear() *= 2;
  EXPECT_THAT(validate(rig).error().message, HasSubstr("T_depth_color"));
}

}  // namespace
}  // namespace meshloop
