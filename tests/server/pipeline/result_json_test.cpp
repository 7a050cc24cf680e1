#include "server/pipeline/result_json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace meshloop {
namespace {

RevisionInfo measured_revision() {
  RevisionInfo info;
  info.revision = 7;
  info.author = "anna";
  info.snapshot.emplace();
  info.snapshot->calibration = "a rig";
  TrackedPose& pose = info.snapshot->depth_pose;
  pose.timestamp_s = 12.5;
  pose.state = TrackState::tracking;
  // A quarter turn about z, 3 m along the camera's x.
  pose.T_camera_world =
      make_pose({3, 0, 0}, Eigen::Quaterniond{Eigen::AngleAxisd{std::numbers::pi / 2, Eigen::Vector3d::UnitZ()}});
  for (int i = 0; i < 36; ++i) pose.covariance(i / 6, i % 6) = i;
  return info;
}

TEST(RevisionJson, HasThePoseFromTheCameraToTheWorld) {
  const auto snapshot = revision_json(measured_revision())["snapshot"];
  const auto translation = snapshot["T_world_depth"]["translation"].get<std::vector<double>>();
  const auto rotation = snapshot["T_world_depth"]["rotation_xyzw"].get<std::vector<double>>();
  ASSERT_EQ(translation.size(), 3u);
  ASSERT_EQ(rotation.size(), 4u);
  EXPECT_NEAR(translation[0], 0, 1e-12);
  EXPECT_NEAR(translation[1], 3, 1e-12);
  EXPECT_NEAR(rotation[2], -std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(rotation[3], std::sqrt(0.5), 1e-12);
  EXPECT_EQ(snapshot["timestamp"], 12.5);
  EXPECT_EQ(snapshot["state"], "tracking");
  EXPECT_TRUE(snapshot["refined_T_world_depth"].is_null());
}

TEST(RevisionJson, HasTheUpperTriangleOfTheCovarianceRowByRow) {
  const auto covariance = revision_json(measured_revision())["snapshot"]["covariance"];
  ASSERT_EQ(covariance.size(), 21u);
  EXPECT_EQ(covariance[0], 0.0);
  EXPECT_EQ(covariance[5], 5.0);
  EXPECT_EQ(covariance[6], 7.0);
  EXPECT_EQ(covariance[20], 35.0);
}

TEST(RevisionJson, NamesTheCalibrationByItsContent) {
  auto info = measured_revision();
  const auto name = revision_json(info)["snapshot"]["calibration"].get<std::string>();
  EXPECT_EQ(name, calibration_name("a rig"));
  EXPECT_EQ(name.size(), 64u);
  EXPECT_NE(name, calibration_name("another rig"));
}

TEST(RevisionJson, HasNoSnapshotWhereNothingWasMeasured) {
  const auto json = revision_json({});
  ASSERT_TRUE(json.contains("snapshot"));
  EXPECT_TRUE(json["snapshot"].is_null());
}

}  // namespace
}  // namespace meshloop
