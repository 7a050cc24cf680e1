#include "common/features/markers.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "plane_scene.h"

namespace meshloop {
namespace {

constexpr double kSide = 0.12;

MarkerDetector make_detector() {
  auto detector = MarkerDetector::create("DICT_4X4_50");
  EXPECT_TRUE(detector) << detector.error().message;
  return std::move(*detector);
}

struct Wall {
  std::vector<test::TexturedPlane> planes;
  MarkerMap map{"DICT_4X4_50", {}};
};

// Markers on a wall at z = 0, seen from negative z; their upper left corners are given in the wall.
Wall wall_with(const std::vector<Eigen::Vector2d>& places, double side = kSide) {
  const MarkerDetector detector = make_detector();
  Wall wall;
  for (std::size_t i = 0; i < places.size(); ++i) {
    Pose T_world_marker = Pose::Identity();
    T_world_marker.translation() = Eigen::Vector3d{places[i].x(), places[i].y(), 0};
    const int id = static_cast<int>(i) + 3;
    wall.planes.push_back(test::marker_plane(*detector.pattern(id), T_world_marker, side));
    wall.map.markers.push_back({id, test::marker_corners(T_world_marker, side)});
  }
  return wall;
}

Wall four_markers() {
  return wall_with({{-0.35, -0.25}, {0.2, -0.22}, {-0.3, 0.12}, {0.22, 0.15}});
}

// Looks at the middle of the wall from `distance`, `angle` to the side.
Pose view_of_wall(double distance, double angle, double roll = 0.1) {
  const Pose T_world_camera =
      look_at({distance * std::sin(angle), 0.1, -distance * std::cos(angle)}, {0, 0, 0}, {std::sin(roll), -1, 0});
  return T_world_camera.inverse();
}

double shift_between(const Pose& a, const Pose& b) {
  return (a.inverse().translation() - b.inverse().translation()).norm();
}

// Corners as they project, each off by a normal error.
std::vector<MarkerSighting> ideal_sightings(const MarkerMap& map, const Pose& T_camera_world, double noise_px,
                                            unsigned seed) {
  std::mt19937 random{seed};
  std::normal_distribution<double> noise{0, noise_px};
  std::vector<MarkerSighting> sightings;
  for (const Marker& marker : map.markers) {
    MarkerSighting sighting{marker.id, {}};
    for (std::size_t k = 0; k < 4; ++k) {
      sighting.pixels[k] = test::vga_camera().project(T_camera_world * marker.corners[k]);
      if (noise_px > 0) sighting.pixels[k] += Eigen::Vector2d{noise(random), noise(random)};
    }
    sightings.push_back(sighting);
  }
  return sightings;
}

TEST(MarkerDetector, RefusesAnUnknownDictionary) {
  const auto detector = MarkerDetector::create("DICT_9X9_1");
  ASSERT_FALSE(detector);
  EXPECT_NE(detector.error().message.find("DICT_9X9_1"), std::string::npos);
}

TEST(MarkerDetector, RefusesAPatternThatTheDictionaryLacks) {
  EXPECT_FALSE(make_detector().pattern(50));
  EXPECT_FALSE(make_detector().pattern(-1));
}

TEST(MarkerDetector, PatternHasABlackBorderAndWhatTheDetectorReads) {
  const auto pattern = make_detector().pattern(7);
  ASSERT_TRUE(pattern);
  ASSERT_EQ(pattern->width(), 6);
  ASSERT_EQ(pattern->height(), 6);
  for (int i = 0; i < 6; ++i) {
    for (const auto value : {(*pattern)(i, 0), (*pattern)(i, 5), (*pattern)(0, i), (*pattern)(5, i)})
      EXPECT_EQ(value, 0);
  }
  GreyImage image{200, 200, 255};
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 120; ++x) image(x + 40, y + 40) = (*pattern)(x / 20, y / 20);
  }
  const auto sightings = make_detector().detect(image);
  ASSERT_EQ(sightings.size(), 1U);
  EXPECT_EQ(sightings[0].id, 7);
  EXPECT_LT((sightings[0].pixels[0] - Eigen::Vector2d{39.5, 39.5}).norm(), 0.1);
  EXPECT_LT((sightings[0].pixels[2] - Eigen::Vector2d{159.5, 159.5}).norm(), 0.1);
}

TEST(MarkerDetector, SeesNothingInAnEmptyTinyOrFlatImage) {
  EXPECT_TRUE(make_detector().detect({}).empty());
  EXPECT_TRUE(make_detector().detect(GreyImage{3, 2, 9}).empty());
  EXPECT_TRUE(make_detector().detect(GreyImage{320, 240, 128}).empty());
}

struct CornerErrors {
  double squares = 0;
  int markers = 0;
  [[nodiscard]] double rms_px() const { return std::sqrt(squares / (8 * markers)); }
};

void add_errors(CornerErrors& errors, const GreyImage& image, const MarkerMap& map, const Pose& truth) {
  for (const MarkerSighting& sighting : make_detector().detect(image)) {
    const Marker& marker = map.markers.at(static_cast<std::size_t>(sighting.id - 3));
    for (std::size_t k = 0; k < 4; ++k) {
      errors.squares += (sighting.pixels[k] - test::vga_camera().project(truth * marker.corners[k])).squaredNorm();
    }
    ++errors.markers;
  }
}

TEST(MarkerDetector, SaysWhichCornersAreRough) {
  const Wall wall = four_markers();
  const auto sightings_at = [&](double distance) {
    const GreyImage image = test::render_planes(wall.planes, test::vga_camera(), view_of_wall(distance, 0.1, 0)).image;
    return make_detector().detect(image);
  };
  const auto near = sightings_at(1);
  ASSERT_EQ(near.size(), 4u);
  for (const auto& sighting : near) EXPECT_EQ(sighting.sigma_px, kMarkerCornerSigmaPx);
  const auto far = sightings_at(8.5);  // a cell is 1.2 pixels wide
  ASSERT_FALSE(far.empty());
  for (const auto& sighting : far) EXPECT_EQ(sighting.sigma_px, kRoughCornerSigmaPx);
}

TEST(MarkerPose, RoughCornersStateALargerUncertainty) {
  const Wall wall = four_markers();
  const Pose truth = view_of_wall(1.2, 0.3);
  auto sightings = ideal_sightings(wall.map, truth, 0, 1);
  const auto fine = pose_from_markers(sightings, wall.map, test::vga_camera(), std::nullopt);
  for (auto& sighting : sightings) sighting.sigma_px = kRoughCornerSigmaPx;
  const auto rough = pose_from_markers(sightings, wall.map, test::vga_camera(), std::nullopt);
  ASSERT_TRUE(fine && rough);
  const double ratio = kRoughCornerSigmaPx / kMarkerCornerSigmaPx;
  EXPECT_NEAR(rough->covariance.trace() / fine->covariance.trace(), ratio * ratio, 0.01 * ratio * ratio);
}

TEST(MarkerDetector, CornersLieWhereTheyProject) {
  const Wall wall = four_markers();
  CornerErrors clean;
  CornerErrors noisy;
  for (int i = 0; i < 6; ++i) {
    const Pose truth = view_of_wall(1 + 0.1 * i, -0.7 + 0.28 * i, 0.2 * i);
    GreyImage image = test::render_planes(wall.planes, test::vga_camera(), truth).image;
    add_errors(clean, image, wall.map, truth);
    test::add_noise(image, 2, static_cast<unsigned>(i));
    add_errors(noisy, image, wall.map, truth);
  }
  std::printf("corner rms: %.3f px, with 2 grey levels of noise %.3f px\n", clean.rms_px(), noisy.rms_px());
  EXPECT_EQ(clean.markers, 24);
  EXPECT_EQ(noisy.markers, 24);
  EXPECT_LT(clean.rms_px(), 0.06);
  EXPECT_LT(noisy.rms_px(), 0.06);
}

TEST(PoseFromMarkers, MillimetreAtOnePointTwoMetres) {
  const Wall wall = four_markers();
  for (int i = 0; i < 4; ++i) {
    const Pose truth = view_of_wall(1.2, -0.6 + 0.4 * i, 0.3 * i);
    GreyImage image = test::render_planes(wall.planes, test::vga_camera(), truth).image;
    const auto clean = pose_from_markers(make_detector().detect(image), wall.map, test::vga_camera(), {});
    ASSERT_TRUE(clean) << i;
    EXPECT_EQ(clean->inliers, 16);
    EXPECT_LT(shift_between(clean->T_camera_world, truth), 0.001) << i;
    test::add_noise(image, 2, static_cast<unsigned>(i));
    const auto noisy = pose_from_markers(make_detector().detect(image), wall.map, test::vga_camera(), {});
    ASSERT_TRUE(noisy) << i;
    EXPECT_LT(shift_between(noisy->T_camera_world, truth), 0.003) << i;
    std::printf("view %d: %.2f mm, with noise %.2f mm\n", i, 1e3 * shift_between(clean->T_camera_world, truth),
                1e3 * shift_between(noisy->T_camera_world, truth));
  }
}

TEST(PoseFromMarkers, OneObliqueMarkerIsEnough) {
  const Wall wall = wall_with({{-0.06, -0.06}});
  const Pose truth = view_of_wall(0.8, 0.8);
  const auto pose = pose_from_markers(ideal_sightings(wall.map, truth, 0.05, 1), wall.map, test::vga_camera(), {});
  ASSERT_TRUE(pose);
  EXPECT_LT(shift_between(pose->T_camera_world, truth), 0.01);
}

// The other pose that fits: the wall tilted the other way.
TEST(PoseFromMarkers, OneFrontalMarkerNeedsAPrior) {
  const Wall wall = wall_with({{-0.03, -0.03}}, 0.06);
  int without_prior = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Pose truth = view_of_wall(2, 0.4, 0);
    const auto sightings = ideal_sightings(wall.map, truth, 0.1, seed);
    const auto alone = pose_from_markers(sightings, wall.map, test::vga_camera(), {});
    if (alone && shift_between(alone->T_camera_world, truth) > 0.3) ++without_prior;
    for (const double side : {1.0, -1.0}) {
      const auto guided = pose_from_markers(sightings, wall.map, test::vga_camera(), view_of_wall(2, side * 0.4, 0));
      ASSERT_TRUE(guided);
      const double x = guided->T_camera_world.inverse().translation().x();
      EXPECT_GT(x * side, -0.05) << "the pose on the prior's side, seed " << seed;
    }
  }
  EXPECT_EQ(without_prior, 0) << "a wrong pose was made up";
}

TEST(PoseFromMarkers, IgnoresAMarkerThatWasMoved) {
  Wall wall = four_markers();
  const Pose truth = view_of_wall(1.2, 0.4);
  const auto sightings = ideal_sightings(wall.map, truth, 0.1, 3);
  for (Eigen::Vector3d& corner : wall.map.markers[1].corners) corner += Eigen::Vector3d{0.05, 0.03, -0.02};
  const auto pose = pose_from_markers(sightings, wall.map, test::vga_camera(), {});
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->inliers, 12);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_FALSE(pose->inlier[4 + k]);
  EXPECT_LT(shift_between(pose->T_camera_world, truth), 0.003);
}

TEST(PoseFromMarkers, OfTwoThatContradictThePriorDecides) {
  Wall wall = wall_with({{-0.3, -0.1}, {0.15, -0.1}});
  const Pose truth = view_of_wall(0.8, 0.6);
  const auto sightings = ideal_sightings(wall.map, truth, 0, 3);
  const Eigen::AngleAxisd turn{0.7, Eigen::Vector3d::UnitY()};
  for (Eigen::Vector3d& corner : wall.map.markers[1].corners) corner = turn * corner;
  EXPECT_FALSE(pose_from_markers(sightings, wall.map, test::vga_camera(), {}));
  const auto pose = pose_from_markers(sightings, wall.map, test::vga_camera(), truth);
  ASSERT_TRUE(pose);
  EXPECT_LT(shift_between(pose->T_camera_world, truth), 0.001);
}

TEST(PoseFromMarkers, NothingWithoutAKnownMarker) {
  const Wall wall = four_markers();
  auto sightings = ideal_sightings(wall.map, view_of_wall(1.2, 0.4), 0, 3);
  EXPECT_FALSE(pose_from_markers({}, wall.map, test::vga_camera(), {}));
  for (MarkerSighting& sighting : sightings) sighting.id += 20;
  EXPECT_FALSE(pose_from_markers(sightings, wall.map, test::vga_camera(), {}));
  sightings = ideal_sightings(wall.map, view_of_wall(1.2, 0.4), 0, 3);
  for (MarkerSighting& sighting : sightings) sighting.pixels[2].x() = std::nan("");
  EXPECT_FALSE(pose_from_markers(sightings, wall.map, test::vga_camera(), {}));
}

TEST(PoseFromMarkers, CovarianceFitsTheErrors) {
  const Wall wall = four_markers();
  constexpr int kSeeds = 200;
  double sum = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const Pose truth = view_of_wall(1.2, 0.4);
    const auto sightings = ideal_sightings(wall.map, truth, 0.1, seed);
    const auto pose = pose_from_markers(sightings, wall.map, test::vga_camera(), {});
    ASSERT_TRUE(pose);
    const Twist error = log(pose->T_camera_world * truth.inverse());
    sum += error.dot(pose->covariance.ldlt().solve(error));
  }
  // 6 for the true covariance; with 16 corners the larger of the stated and the seen noise lies above the true one.
  EXPECT_GT(sum / kSeeds, 4.5);
  EXPECT_LT(sum / kSeeds, 6.7);
}

}  // namespace
}  // namespace meshloop
