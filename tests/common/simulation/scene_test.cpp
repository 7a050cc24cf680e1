#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/features/markers.h"
#include "common/simulation/camera_path.h"
#include "common/simulation/demo_scene.h"
#include "common/simulation/sensor.h"

namespace meshloop::simulation {
namespace {

const Camera kColor{640, 480, 525, 525, 319.5, 239.5, {}};
const Camera kDepth{640, 480, 585, 585, 319.5, 239.5, {}};
constexpr double kEdge_m = 0.02;

TEST(DemoScene, ModelHoldsSideboardAndBricksOfReasonableSize) {
  const auto parts = tessellate(make_demo_scene(1), true, kEdge_m);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].name, "sideboard");
  EXPECT_EQ(parts[1].name, "bricks");
  const auto triangles = parts[0].submesh.triangles.size() + parts[1].submesh.triangles.size();
  EXPECT_GT(triangles, 60'000u);
  EXPECT_LT(triangles, 110'000u);
}

TEST(DemoScene, MarkersAreNoPartOfTheModelsColors) {
  const auto parts = tessellate(make_demo_scene(1), true, kEdge_m);
  int darkest = 255;
  for (std::size_t i = 0; i < parts[0].submesh.positions.size(); ++i) {
    if (std::abs(parts[0].submesh.positions[i].z()) < 1e-6f) {
      darkest = std::min<int>(darkest, parts[0].submesh.colors[i].r);
    }
  }
  EXPECT_GT(darkest, 120);
}

std::map<std::string, Eigen::AlignedBox3d> object_boxes(const Scene& scene) {
  std::map<std::string, Eigen::AlignedBox3d> boxes;
  for (const Solid& solid : scene.solids) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      boxes[solid.object].extend(solid.T_world_solid * (solid.size / 2).cwiseProduct(sign));
    }
  }
  return boxes;
}

TEST(DemoScene, ObjectsStandOnTheSideboardApartFromEachOtherBeforeAndAfterTheMove) {
  const Scene before = make_demo_scene(1);
  for (const Scene& scene : {before, with_moved_object(before, "box", kBoxMove_m)}) {
    auto boxes = object_boxes(scene);
    boxes.erase("sideboard");
    ASSERT_EQ(boxes.size(), 3u);
    for (const auto& [name, box] : boxes) {
      EXPECT_NEAR(box.min().z(), 0, 1e-9) << name;
      EXPECT_LT(box.max().head<2>().cwiseAbs().maxCoeff(), 0.8) << name;
      EXPECT_LT(std::max(box.max().y(), -box.min().y()), 0.3) << name;
      for (const auto& [other_name, other] : boxes) {
        if (name != other_name) {
          EXPECT_FALSE(box.intersects(other)) << name << ", " << other_name;
        }
      }
    }
  }
}

TEST(DemoScene, MovesOnlyTheBoxByTwoCentimetres) {
  EXPECT_NEAR(kBoxMove_m.norm(), 0.02, 1e-12);
  EXPECT_EQ(kBoxMove_m.z(), 0);
  const Scene before = make_demo_scene(1);
  const Scene after = with_moved_object(before, "box", kBoxMove_m);
  for (std::size_t i = 0; i < before.solids.size(); ++i) {
    const Eigen::Vector3d moved =
        after.solids[i].T_world_solid.translation() - before.solids[i].T_world_solid.translation();
    const Eigen::Vector3d expected =
        before.solids[i].object == "box" ? kBoxMove_m : Eigen::Vector3d(Eigen::Vector3d::Zero());
    EXPECT_LT((moved - expected).norm(), 1e-12);
  }
}

// Shares of the box's pixels seen from the front: with the model behind them, and without.
TEST(DemoScene, BoxStandsPartlyBeforeTheModelAndPartlyAboveIt) {
  const Scene scene = make_demo_scene(1);
  const Pose T_camera_world = StationPath{6, 0}.at(0).inverse();
  const ExactDepth all = cast_depth(scene, kDepth, T_camera_world, false);
  const ExactDepth model = cast_depth(scene, kDepth, T_camera_world, true);
  int before_model = 0;
  int above_model = 0;
  for (std::size_t i = 0; i < all.depth.size(); ++i) {
    const auto solid = all.solid.pixels()[i];
    if (solid == 0 || scene.solids[solid - 1u].object != "box") continue;
    (model.depth.pixels()[i] > 0 ? before_model : above_model) += 1;
  }
  EXPECT_GT(before_model, 3000);
  EXPECT_GT(above_model, 3000);
}

TEST(DemoScene, MoveMakesTheBoxsFrontFarther) {
  const Scene before = make_demo_scene(1);
  const Scene after = with_moved_object(before, "box", kBoxMove_m);
  const Pose T_camera_world = StationPath{6, 1}.at(0).inverse();
  const ExactDepth first = cast_depth(before, kDepth, T_camera_world, false);
  const ExactDepth second = cast_depth(after, kDepth, T_camera_world, false);
  int farther = 0;
  int box = 0;
  for (std::size_t i = 0; i < first.depth.size(); ++i) {
    const auto solid = first.solid.pixels()[i];
    if (solid == 0 || before.solids[solid - 1u].object != "box") continue;
    ++box;
    const float z = second.depth.pixels()[i];
    if (z > 0 && z - first.depth.pixels()[i] > 0.01f) ++farther;
  }
  EXPECT_GT(farther, box / 2);
}

struct Sightings {
  int known = 0;
  double squared_px = 0;
};

Sightings sight_markers(const MarkerDetector& detector, const Scene& scene, const Pose& T_world_color,
                        std::uint64_t seed) {
  ColorImage image = cast_color(scene, kColor, T_world_color.inverse(), 2);
  add_color_noise(image, 2, seed);
  const MarkerMap map = demo_markers();
  Sightings sightings;
  for (const MarkerSighting& sighting : detector.detect(to_grey(image))) {
    for (const Marker& marker : map.markers) {
      if (marker.id != sighting.id) continue;
      ++sightings.known;
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector2d expected = kColor.project(T_world_color.inverse() * marker.corners[i]);
        sightings.squared_px += (expected - sighting.pixels[i]).squaredNorm();
      }
    }
  }
  return sightings;
}

TEST(DemoScene, StationFindsMarkersWhereTheMapSaysFromAllAround) {
  const auto detector = MarkerDetector::create(demo_markers().dictionary);
  ASSERT_TRUE(detector);
  const Scene scene = make_demo_scene(1);
  double squared_px = 0;
  int corners = 0;
  constexpr int kViews = 12;
  for (int i = 0; i < kViews; ++i) {
    const Pose T_world_color = StationPath{6, i % 2}.at(6.0 * i / kViews);
    const Sightings seen = sight_markers(*detector, scene, T_world_color, static_cast<std::uint64_t>(i));
    EXPECT_GE(seen.known, 2) << "view " << i;
    squared_px += seen.squared_px;
    corners += 4 * seen.known;
  }
  // Markers at the far end are 15 pixels high; their corners alone are off by up to 3 pixels.
  EXPECT_LT(std::sqrt(squared_px / corners), 0.6);
}

// The device looks at the box from near and loses sight of all markers on its way; it needs one where it starts.
TEST(DemoScene, DeviceFindsAMarkerWhereItStartsBeforeAndAfterTheMove) {
  const auto detector = MarkerDetector::create(demo_markers().dictionary);
  ASSERT_TRUE(detector);
  const Scene before = make_demo_scene(1);
  for (const Scene& scene : {before, with_moved_object(before, "box", kBoxMove_m)}) {
    for (const DevicePath& path : {DevicePath{}, DevicePath{.farthest_m = 0.57, .nearest_m = 0.45}}) {
      const Sightings seen = sight_markers(*detector, scene, path.at(0), 1);
      ASSERT_GE(seen.known, 1);
      EXPECT_LT(std::sqrt(seen.squared_px / (4 * seen.known)), 0.3);
    }
  }
}

TEST(CameraPath, KeepsItsDistanceAndStartsInFront) {
  for (const int half : {0, 1}) {
    for (double t = 0; t <= 6; t += 0.05) {
      const Eigen::Vector3d eye = StationPath{6, half}.at(t).translation();
      EXPECT_GT(eye.norm(), 1.1);
      EXPECT_LT(eye.norm(), 1.4);
      EXPECT_GT(eye.z(), 0.45);
      EXPECT_LT(eye.z(), 0.8);
    }
    EXPECT_LT(StationPath({6, half}).at(0).translation().y(), -1.0);
  }
}

TEST(CameraPath, RestsAtFivePlacesAndGoesAllTheWayRound) {
  const StationPath path{6, 0};
  int slow = 0;
  double angle = 0;
  constexpr double kFrame_s = 0.1;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d a = path.at(kFrame_s * i).translation();
    const Eigen::Vector3d b = path.at(kFrame_s * (i + 1)).translation();
    const double step = std::atan2(a.x() * b.y() - a.y() * b.x(), a.x() * b.x() + a.y() * b.y());
    angle += step;
    slow += std::abs(step) < 0.035 ? 1 : 0;
  }
  EXPECT_NEAR(std::abs(angle), 2 * 3.14159265, 0.05);
  EXPECT_GE(slow, 20);
}

}  // namespace
}  // namespace meshloop::simulation
