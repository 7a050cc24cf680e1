#include "common/features/klt.h"

#include <gtest/gtest.h>

#include <cmath>

#include "plane_scene.h"

namespace meshloop {
namespace {

Camera small_camera() {
  Camera camera = test::vga_camera();
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 262.5;
  camera.cx = 159.5;
  camera.cy = 119.5;
  return camera;
}

// A wall 1 m in front of the first camera.
test::TexturedPlane wall() {
  test::TexturedPlane plane;
  plane.T_world_plane.translation() = Eigen::Vector3d{-1.5, -1, 1};
  plane.width_m = 3;
  plane.height_m = 2;
  plane.texture = test::blotches(150, 100, 5);
  return plane;
}

Pose shifted(double x_m, double y_m) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d{x_m, y_m, 0};
  return pose;
}

GreyImage chequer(int width, int height, int cell) {
  GreyImage image{width, height};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image(x, y) = (x / cell + y / cell) % 2 == 0 ? std::uint8_t{40} : std::uint8_t{210};
  }
  return image;
}

TEST(FlowOptions, FollowTheWidthOfThePicture) {
  EXPECT_EQ(flow_options_for(640).window_px, FlowOptions{}.window_px);
  EXPECT_EQ(flow_options_for(640).pyramid_levels, FlowOptions{}.pyramid_levels);
  EXPECT_EQ(corner_options_for(640).min_distance_px, CornerOptions{}.min_distance_px);
  EXPECT_EQ(flow_options_for(176).window_px, 11);
  EXPECT_EQ(flow_options_for(176).pyramid_levels, 3);
  EXPECT_NEAR(corner_options_for(160).min_distance_px, 5, 1e-12);
  EXPECT_EQ(flow_options_for(1280).window_px, FlowOptions{}.window_px);
  EXPECT_EQ(flow_options_for(1280).pyramid_levels, 5);
  EXPECT_GT(flow_options_for(0).window_px, 0);
}

TEST(FindCorners, FindsThemWhereAChequerHasThem) {
  const auto corners = find_corners(chequer(200, 160, 40), {}, {}, {});
  EXPECT_EQ(corners.size(), 12U);
  for (const Eigen::Vector2d& p : corners) {
    const Eigen::Vector2d nearest{std::round((p.x() + 0.5) / 40) * 40 - 0.5, std::round((p.y() + 0.5) / 40) * 40 - 0.5};
    EXPECT_LT((p - nearest).norm(), 1.5);
  }
}

TEST(FindCorners, KeepTheirDistanceToEachOtherAndToThoseTaken) {
  const GreyImage image = test::render_planes({wall()}, small_camera(), Pose::Identity(), 1).image;
  const std::vector<Eigen::Vector2d> taken{{50, 50}, {160, 120}, {162, 121}};
  const auto corners = find_corners(image, {}, taken, {});
  EXPECT_GT(corners.size(), 50U);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((corners[i] - corners[j]).norm(), 10);
    for (const Eigen::Vector2d& p : taken) EXPECT_GE((corners[i] - p).norm(), 10);
  }
}

TEST(FindCorners, OneTexturedObjectDoesNotTakeThemAll) {
  GreyImage image = chequer(320, 240, 12);
  for (int y = 0; y < 240; ++y) {
    for (int x = 160; x < 320; ++x) image(x, y) = static_cast<std::uint8_t>(100 + image(x, y) / 8);
  }
  CornerOptions options;
  options.max_corners = 72;
  const auto corners = find_corners(image, {}, {}, options);
  const auto left = std::count_if(corners.begin(), corners.end(), [](const auto& p) { return p.x() < 160; });
  EXPECT_EQ(corners.size(), 72U);
  EXPECT_NEAR(static_cast<double>(left), 36, 4);
}

TEST(FindCorners, StayWhereTheMaskIsSet) {
  const GreyImage image = test::render_planes({wall()}, small_camera(), Pose::Identity(), 1).image;
  GreyImage mask{320, 240};
  for (int y = 60; y < 120; ++y) {
    for (int x = 100; x < 200; ++x) mask(x, y) = 1;
  }
  const auto corners = find_corners(image, mask, {}, {});
  EXPECT_GT(corners.size(), 5U);
  for (const Eigen::Vector2d& p : corners) EXPECT_TRUE(p.x() >= 100 && p.x() < 200 && p.y() >= 60 && p.y() < 120);
}

TEST(FindCorners, NoneInAFlatEmptyOrTinyImage) {
  EXPECT_TRUE(find_corners(GreyImage{100, 100, 77}, {}, {}, {}).empty());
  EXPECT_TRUE(find_corners(GreyImage{}, {}, {}, {}).empty());
  EXPECT_TRUE(find_corners(chequer(6, 6, 2), {}, {}, {}).empty());
}

TEST(TrackPoints, FollowsToAFractionOfAPixel) {
  const Camera camera = small_camera();
  const GreyImage from = test::render_planes({wall()}, camera, Pose::Identity()).image;
  const Eigen::Vector2d motion{7.3, -4.6};
  const GreyImage to = test::render_planes({wall()}, camera, shifted(motion.x() / 262.5, motion.y() / 262.5)).image;
  const auto corners = find_corners(from, {}, {}, {});
  const auto tracked = track_points(from, to, corners, {}, {});
  int found = 0;
  double squares = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!tracked[i].found) continue;
    ++found;
    squares += (tracked[i].pixel - corners[i] - motion).squaredNorm();
  }
  EXPECT_GT(found, static_cast<int>(corners.size() * 9 / 10));
  EXPECT_LT(std::sqrt(squares / found), 0.1);
}

TEST(TrackPoints, AGuessReachesFurther) {
  const Camera camera = small_camera();
  const GreyImage from = test::render_planes({wall()}, camera, Pose::Identity()).image;
  const GreyImage to = test::render_planes({wall()}, camera, shifted(100 / 262.5, 0)).image;
  std::vector<Eigen::Vector2d> corners;
  std::vector<Eigen::Vector2d> guesses;
  for (const Eigen::Vector2d& p : find_corners(from, {}, {}, {})) {
    if (p.x() > 190) continue;
    corners.push_back(p);
    guesses.emplace_back(p.x() + 97, p.y() + 2);
  }
  const auto tracked = track_points(from, to, corners, guesses, {});
  int right = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (tracked[i].found && (tracked[i].pixel - corners[i] - Eigen::Vector2d{100, 0}).norm() < 0.3) ++right;
  }
  EXPECT_GT(right, static_cast<int>(corners.size() * 9 / 10));
}

TEST(TrackPoints, LosesWhatIsCovered) {
  const Camera camera = small_camera();
  const GreyImage from = test::render_planes({wall()}, camera, Pose::Identity()).image;
  GreyImage to = from;
  for (int y = 80; y < 160; ++y) {
    for (int x = 100; x < 220; ++x) to(x, y) = 128;
  }
  const auto tracked = track_points(from, to, {{160, 120}, {150, 110}, {30, 30}}, {}, {});
  EXPECT_FALSE(tracked[0].found);
  EXPECT_FALSE(tracked[1].found);
  EXPECT_TRUE(tracked[2].found);
}

TEST(TrackPoints, LosesWhatLeavesTheImage) {
  const Camera camera = small_camera();
  const GreyImage from = test::render_planes({wall()}, camera, Pose::Identity()).image;
  const GreyImage to = test::render_planes({wall()}, camera, shifted(20 / 262.5, 0)).image;
  const auto tracked = track_points(from, to, {{310, 100}, {150, 110}}, {}, {});
  EXPECT_FALSE(tracked[0].found);
}

TEST(TrackPoints, FindsNothingInWhatDoesNotFit) {
  const GreyImage a = chequer(100, 80, 10);
  const std::vector<Eigen::Vector2d> points{{50, 40}, {20, 20}};
  EXPECT_FALSE(track_points(a, chequer(80, 100, 10), points, {}, {})[0].found);
  EXPECT_FALSE(track_points({}, {}, points, {}, {})[1].found);
  EXPECT_FALSE(track_points(a, a, points, {{50, 40}}, {})[0].found);
  EXPECT_FALSE(track_points(a, a, {{std::nan(""), 3}}, {}, {})[0].found);
  EXPECT_FALSE(track_points(a, a, {{-500, 1e9}}, {}, {})[0].found);
  EXPECT_TRUE(track_points(a, a, {}, {}, {}).empty());
}

}  // namespace
}  // namespace meshloop
