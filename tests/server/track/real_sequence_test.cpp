// The real sequence mbt-depth/castel of Debian's package visp-images-data: 30 grey and depth images of a model castle,
// its CAD model and the pose of the first image.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/recording/recording.h"
#include "server/track/rig_tracker.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;
using Triangle = std::array<Eigen::Vector3d, 3>;

const fs::path kSequence{"/usr/share/visp-images-data/ViSP-images/mbt-depth/castel"};

Pose read_start(const fs::path& file) {
  std::ifstream in{file};
  std::array<double, 7> n{};
  char comma = 0;
  for (std::size_t i = 0; i < n.size(); ++i) {
    if (i > 0) in >> comma;
    in >> n[i];
  }
  return make_pose({n[0], n[1], n[2]}, Eigen::Quaterniond{n[6], n[3], n[4], n[5]}).inverse();
}

std::vector<Triangle> read_triangles(const fs::path& file) {
  std::ifstream in{file};
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words{line};
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Eigen::Vector3d p;
      words >> p.x() >> p.y() >> p.z();
      vertices.push_back(p);
    } else if (kind == "f") {
      std::array<std::size_t, 3> f{};
      words >> f[0] >> f[1] >> f[2];
      triangles.push_back({vertices.at(f[0] - 1), vertices.at(f[1] - 1), vertices.at(f[2] - 1)});
    }
  }
  return triangles;
}

// Depth of the nearest triangle along a ray of the camera, 0 where there is none.
double cast(const std::vector<Triangle>& triangles, const Pose& T_camera_world, const Eigen::Vector3d& ray) {
  double nearest = 0;
  for (const Triangle& triangle : triangles) {
    const Eigen::Vector3d a = T_camera_world * triangle[0];
    Eigen::Matrix3d m;
    m << ray, a - T_camera_world * triangle[1], a - T_camera_world * triangle[2];
    const Eigen::Vector3d x = m.fullPivLu().solve(a);
    const bool inside = x[1] >= 0 && x[2] >= 0 && x[1] + x[2] <= 1 && x[0] > 0;
    if (inside && (nearest == 0 || x[0] < nearest)) nearest = x[0];
  }
  return nearest;
}

// Median distance between what the depth camera measures and the CAD model, where both are.
double median_difference(const std::vector<Triangle>& triangles, const Rig& rig, const RgbdFrame& frame,
                         const Pose& T_color_world) {
  std::vector<double> differences;
  const Pose T_depth_world = rig.T_depth_color * T_color_world;
  for (int y = 4; y < frame.depth.height(); y += 24) {
    for (int x = 4; x < frame.depth.width(); x += 24) {
      const double expected = cast(triangles, T_depth_world, rig.depth.back_project(x, y, 1));
      if (expected > 0 && frame.depth(x, y) > 0) differences.push_back(std::abs(frame.depth(x, y) - expected));
    }
  }
  if (differences.size() < 50) return 1;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle;
}

TEST(RigTracker, HoldsARealSequence) {
  if (!fs::exists(kSequence)) GTEST_SKIP() << "needs Debian's package visp-images-data";
  const fs::path root = fs::path{__FILE__}.parent_path() / "../../..";
  const fs::path folder = fs::path{testing::TempDir()} / "castel";
  const std::string command = "python3 '" + (root / "deploy/convert_castel.py").string() + "' '" + kSequence.string() +
                              "' '" + folder.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto recording = Recording::open(folder);
  ASSERT_TRUE(recording) << recording.error().message;
  const std::vector<Triangle> triangles = read_triangles(folder / "model.obj");
  auto tracker = RigTracker::create(recording->rig(), {{}, read_start(folder / "start_pose.txt")});
  ASSERT_TRUE(tracker) << tracker.error().message;
  double first = 0;
  double last = 0;
  for (int i = 0; i < static_cast<int>(recording->depth_images().size()); ++i) {
    const auto frame = recording->read_frame(i);
    ASSERT_TRUE(frame) << frame.error().message;
    const TrackedPose pose = (*tracker)->track(*frame);
    ASSERT_EQ(pose.state, TrackState::tracking) << "frame " << i;
    EXPECT_GT(pose.quality, 0.6) << "frame " << i;
    if (i == 0) first = median_difference(triangles, recording->rig(), *frame, pose.T_camera_world);
    if (i == 29) last = median_difference(triangles, recording->rig(), *frame, pose.T_camera_world);
  }
  std::printf("median distance of the depth to the CAD model: first %.1f mm, last %.1f mm\n", 1e3 * first, 1e3 * last);
  EXPECT_LT(first, 0.006);
  EXPECT_LT(last, first + 0.002);
}

}  // namespace
}  // namespace meshloop
