#include "server/track/rig_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/features/markers.h"
#include "plane_scene.h"

namespace meshloop {
namespace {

Rig small_rig() {
  Rig rig;
  rig.color = test::vga_camera();
  rig.color.width = 320;
  rig.color.height = 240;
  rig.color.fx = rig.color.fy = 262.5;
  rig.color.cx = 159.5;
  rig.color.cy = 119.5;
  rig.depth = rig.color;
  rig.depth.fx = rig.depth.fy = 290;
  rig.T_depth_color.translation() = Eigen::Vector3d{-0.025, 0.002, 0.001};
  return rig;
}

// A corner of a room: wall, floor and a board in front of it.
std::vector<test::TexturedPlane> room() {
  test::TexturedPlane wall;
  wall.T_world_plane.translation() = Eigen::Vector3d{-2, -1.5, 0.4};
  wall.width_m = 4;
  wall.height_m = 2.2;
  wall.texture = test::blotches(200, 110, 1);
  test::TexturedPlane floor;
  floor.T_world_plane.translation() = Eigen::Vector3d{-2, 0.5, 0.4};
  floor.T_world_plane.linear() = Eigen::AngleAxisd{-M_PI / 2, Eigen::Vector3d::UnitX()}.toRotationMatrix();
  floor.width_m = 4;
  floor.height_m = 2;
  floor.texture = test::blotches(200, 100, 2);
  test::TexturedPlane board;
  board.T_world_plane.translation() = Eigen::Vector3d{-0.2, -0.1, 0.1};
  board.T_world_plane.linear() = Eigen::AngleAxisd{0.4, Eigen::Vector3d::UnitY()}.toRotationMatrix();
  board.width_m = 0.4;
  board.height_m = 0.3;
  board.texture = test::blotches(30, 22, 3);
  return {wall, floor, board};
}

struct Scene {
  Rig rig = small_rig();
  std::vector<test::TexturedPlane> planes = room();
  MarkerMap map{"DICT_4X4_50", {}};

  void add_marker(int id, double x, double y, double side) {
    Pose T_world_marker = Pose::Identity();
    T_world_marker.translation() = Eigen::Vector3d{x, y, 0.399};
    const auto detector = MarkerDetector::create(map.dictionary);
    planes.push_back(test::marker_plane(*detector->pattern(id), T_world_marker, side));
    map.markers.push_back({id, test::marker_corners(T_world_marker, side)});
  }

  // Colour at the time, depth a little later, as the rig at each of the two stands.
  RgbdFrame frame(int index, double time_s, const Pose& T_color_world, const Pose& at_depth_time) const {
    RgbdFrame frame;
    frame.index = index;
    frame.color_timestamp_s = time_s;
    frame.depth_timestamp_s = time_s + 0.01;
    frame.color = to_color(test::render_planes(planes, rig.color, T_color_world, 3).image);
    frame.depth = test::render_planes(planes, rig.depth, rig.T_depth_color * at_depth_time, 1).depth;
    return frame;
  }
};

// 2 cm a frame to the side, always looking at the board.
Pose on_path(double frame) {
  const double x = -0.3 + 0.02 * frame;
  return look_at({x, -0.25, -0.9}, {0.1 * x, 0, 0.3}, {0, -1, 0}).inverse();
}

RgbdFrame path_frame(const Scene& scene, int i) {
  return scene.frame(i, i / 30.0, on_path(i), on_path(i + 0.3));
}

double shift_m(const Pose& a, const Pose& b) {
  return (a.inverse().translation() - b.inverse().translation()).norm();
}

RgbdFrame black(const Rig& rig, int i) {
  RgbdFrame frame;
  frame.index = i;
  frame.color_timestamp_s = frame.depth_timestamp_s = i / 30.0;
  frame.color = ColorImage{rig.color.width, rig.color.height};
  frame.depth = DepthImage{rig.depth.width, rig.depth.height};
  return frame;
}

std::unique_ptr<RigTracker> make_tracker(const Scene& scene, const std::optional<Pose>& first) {
  RigTrackerOptions options;
  if (!scene.map.markers.empty()) options.markers = scene.map;
  options.first_pose = first;
  auto tracker = RigTracker::create(scene.rig, options);
  EXPECT_TRUE(tracker) << tracker.error().message;
  return std::move(*tracker);
}

TEST(RigTracker, RefusesToStartFromNothing) {
  EXPECT_FALSE(RigTracker::create(small_rig(), {}));
  EXPECT_FALSE(RigTracker::create(small_rig(), {MarkerMap{"DICT_4X4_50", {}}, {}}));
  Pose broken = Pose::Identity();
  broken.linear() *= 1.1;
  EXPECT_FALSE(RigTracker::create(small_rig(), {{}, broken}));
  Scene scene;
  scene.add_marker(1, 0, 0, 0.1);
  scene.map.dictionary = "DICT_NONE";
  EXPECT_FALSE(RigTracker::create(small_rig(), {scene.map, {}}));
  Rig rig = small_rig();
  rig.color.fx = 0;
  EXPECT_FALSE(RigTracker::create(rig, {{}, Pose::Identity()}));
}

TEST(RigTracker, FeaturesDriftLessThanACentimetreInThirtyFrames) {
  const Scene scene;
  const auto tracker = make_tracker(scene, on_path(0));
  double worst = 0;
  double last_spread = 0;
  for (int i = 0; i < 30; ++i) {
    const TrackedPose pose = tracker->track(path_frame(scene, i));
    ASSERT_EQ(pose.state, TrackState::tracking) << "frame " << i;
    worst = std::max(worst, shift_m(pose.T_camera_world, on_path(i)));
    if (i > 0) {
      EXPECT_GT(pose.quality, 0.6);
      EXPECT_GE(pose.inliers, 50);
    }
    last_spread = std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace());
  }
  std::printf("worst drift %.2f mm, stated at the end %.2f mm\n", 1e3 * worst, 1e3 * last_spread);
  EXPECT_LT(worst, 0.01);
  EXPECT_GT(last_spread, worst / 3) << "the stated uncertainty must grow with the drift";
  EXPECT_LT(last_spread, 0.01);
}

TEST(RigTracker, MarkersSetThePoseAndFeaturesTakeOver) {
  Scene scene;
  scene.add_marker(4, -0.62, -0.5, 0.25);
  scene.add_marker(5, 0.25, -0.5, 0.25);
  scene.add_marker(6, -0.62, 0.1, 0.25);
  const auto tracker = make_tracker(scene, {});
  Scene hidden = scene;
  hidden.planes.resize(3);
  for (int i = 0; i < 12; ++i) {
    const TrackedPose pose = tracker->track(path_frame(i < 4 ? scene : hidden, i));
    ASSERT_EQ(pose.state, i == 0 ? TrackState::relocalised : TrackState::tracking) << "frame " << i;
    EXPECT_LT(shift_m(pose.T_camera_world, on_path(i)), 0.005) << "frame " << i;
  }
}

TEST(RigTracker, SaysLostAndRecoversByMarker) {
  Scene scene;
  scene.add_marker(4, -0.62, -0.5, 0.25);
  scene.add_marker(5, 0.25, -0.5, 0.25);
  scene.add_marker(6, -0.62, 0.1, 0.25);
  const auto tracker = make_tracker(scene, {});
  EXPECT_EQ(tracker->track(path_frame(scene, 0)).state, TrackState::relocalised);
  for (int i = 1; i < 13; ++i) {
    const TrackedPose pose = tracker->track(black(scene.rig, i));
    EXPECT_EQ(pose.state, TrackState::lost);
    EXPECT_EQ(pose.inliers, 0);
  }
  const TrackedPose back = tracker->track(path_frame(scene, 13));
  EXPECT_EQ(back.state, TrackState::relocalised);
  EXPECT_LT(shift_m(back.T_camera_world, on_path(13)), 0.005);
}

TEST(RigTracker, ComesBackByItsFeaturesWithinTenFramesOnly) {
  const Scene scene;
  for (const int gap : {4, 14}) {
    const auto tracker = make_tracker(scene, on_path(0));
    for (int i = 0; i < 3; ++i) ASSERT_NE(tracker->track(path_frame(scene, i)).state, TrackState::lost);
    for (int i = 3; i < 3 + gap; ++i) ASSERT_EQ(tracker->track(black(scene.rig, i)).state, TrackState::lost);
    RgbdFrame again = path_frame(scene, 4);
    again.color_timestamp_s = (3 + gap) / 30.0;
    const TrackedPose pose = tracker->track(again);
    if (gap == 14) {
      EXPECT_EQ(pose.state, TrackState::lost);
      continue;
    }
    ASSERT_EQ(pose.state, TrackState::relocalised);
    EXPECT_LT(shift_m(pose.T_camera_world, on_path(4)), 0.005);
  }
}

TEST(RigTracker, MakesNoPoseUpInAnotherPlace) {
  const Scene scene;
  Scene other;
  for (std::size_t i = 0; i < other.planes.size(); ++i)
    other.planes[i].texture = test::blotches(180, 90, 50 + static_cast<unsigned>(i));
  const auto tracker = make_tracker(scene, on_path(0));
  ASSERT_NE(tracker->track(path_frame(scene, 0)).state, TrackState::lost);
  EXPECT_EQ(tracker->track(path_frame(other, 1)).state, TrackState::lost);
}

TEST(RigTracker, AFrameOfAnotherSizeIsLostAndTheNextIsNot) {
  const Scene scene;
  const auto tracker = make_tracker(scene, on_path(0));
  ASSERT_NE(tracker->track(path_frame(scene, 0)).state, TrackState::lost);
  RgbdFrame wrong = path_frame(scene, 1);
  wrong.color = ColorImage{64, 48};
  EXPECT_EQ(tracker->track(wrong).state, TrackState::lost);
  RgbdFrame no_depth = path_frame(scene, 2);
  no_depth.depth = {};
  EXPECT_EQ(tracker->track(no_depth).state, TrackState::relocalised);
  EXPECT_EQ(tracker->track(path_frame(scene, 3)).state, TrackState::tracking);
}

TEST(RigTracker, UsesDepthThatLiesInTheColourPixels) {
  Scene scene;
  scene.rig.depth_registered = true;
  scene.rig.depth = scene.rig.color;
  scene.rig.T_depth_color = Pose::Identity();
  const auto tracker = make_tracker(scene, on_path(0));
  for (int i = 0; i < 5; ++i) {
    const TrackedPose pose = tracker->track(scene.frame(i, i / 30.0, on_path(i), on_path(i)));
    ASSERT_EQ(pose.state, TrackState::tracking);
    EXPECT_LT(shift_m(pose.T_camera_world, on_path(i)), 0.01);
  }
}

}  // namespace
}  // namespace meshloop
