#include "device/track/feature_set.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

Camera camera() {
  return {64, 48, 60, 60, 31.5, 23.5, {}};
}

/// At the world's origin, looking along z.
Pose pose_at_x(double x_m) {
  Pose T_camera_world = Pose::Identity();
  T_camera_world.translation().x() = -x_m;
  return T_camera_world;
}

/// Of a point 1 m ahead, seen `off_px` from where the camera at x projects it.
Feature feature_seen(double x_m, double off_px, bool trusted) {
  Feature feature;
  feature.p_world = {0.05, 0, 1};
  feature.pixel = camera().project(pose_at_x(x_m) * feature.p_world) + Eigen::Vector2d{off_px, 0};
  feature.trusted = trusted;
  return feature;
}

TEST(FeatureSet, ATrustedFeatureGoesAfterThreeContradictionsInARow) {
  FeatureSet features{feature_seen(0, 3, true)};
  features = judged(features, camera(), pose_at_x(0));
  features = judged(features, camera(), pose_at_x(0));
  ASSERT_EQ(features.size(), 1u);
  EXPECT_TRUE(judged(features, camera(), pose_at_x(0)).empty());
  features[0].pixel = feature_seen(0, 0, true).pixel;
  features = judged(features, camera(), pose_at_x(0));
  ASSERT_EQ(features.size(), 1u);
  EXPECT_EQ(features[0].contradictions, 0);
}

TEST(FeatureSet, AFeatureOnProbationGoesAtTheFirstContradiction) {
  EXPECT_TRUE(judged({feature_seen(0, 3, false)}, camera(), pose_at_x(0)).empty());
}

TEST(FeatureSet, AFeatureOnProbationIsTrustedOnceAWrongDepthWouldHaveShown) {
  const FeatureSet near = judged({feature_seen(0.1, 0, false)}, camera(), pose_at_x(0.1));
  ASSERT_EQ(near.size(), 1u);
  EXPECT_FALSE(near[0].trusted);
  const FeatureSet far = judged({feature_seen(0.2, 0, false)}, camera(), pose_at_x(0.2));
  ASSERT_EQ(far.size(), 1u);
  EXPECT_TRUE(far[0].trusted);
  const FeatureSet vague = judged({feature_seen(0.2, 1, false)}, camera(), pose_at_x(0.2));
  ASSERT_EQ(vague.size(), 1u);
  EXPECT_FALSE(vague[0].trusted);
}

TEST(FeatureSet, OnlyTrustedOnesBearOnThePose) {
  const FeatureSet features{feature_seen(0, 0, true), feature_seen(0, 0, false)};
  EXPECT_EQ(observations_of(features, 1).size(), 1u);
  EXPECT_EQ(observations_of_all(features, 1).size(), 2u);
}

TEST(FeatureSet, WhatIsNoLongerOnTheSurfaceIsLeftOut) {
  RenderedView view;
  view.camera = camera();
  view.depth = DepthImage{64, 48, 1.0f};
  Feature hidden = feature_seen(0, 0, true);
  hidden.p_world.z() = 1.05;
  Feature behind_the_camera = feature_seen(0, 0, true);
  behind_the_camera.p_world.z() = -1;
  EXPECT_EQ(on_surface({feature_seen(0, 0, true), hidden, behind_the_camera}, view).size(), 1u);
}

}  // namespace
}  // namespace meshloop
