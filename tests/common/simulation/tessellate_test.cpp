#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/simulation/camera_path.h"
#include "common/simulation/random.h"
#include "common/simulation/sensor.h"

namespace meshloop::simulation {
namespace {

const Camera kDepth{640, 480, 585, 585, 319.5, 239.5, {}};
constexpr double kEdge_m = 0.02;

Submesh joined(const std::vector<SolidMesh>& parts) {
  Submesh all;
  for (const SolidMesh& part : parts) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), part.submesh.positions.begin(), part.submesh.positions.end());
    for (const auto& [a, b, c] : part.submesh.triangles) all.triangles.push_back({a + first, b + first, c + first});
  }
  return all;
}

// Moeller, Trumbore 1997, over all triangles that face the ray.
std::optional<double> nearest_triangle(const Submesh& mesh, const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d p = mesh.positions[a].cast<double>();
    const Eigen::Vector3d ab = mesh.positions[b].cast<double>() - p;
    const Eigen::Vector3d ac = mesh.positions[c].cast<double>() - p;
    const Eigen::Vector3d across = direction.cross(ac);
    const double determinant = ab.dot(across);
    if (determinant < 1e-14) continue;
    const Eigen::Vector3d to_origin = origin - p;
    const double u = to_origin.dot(across) / determinant;
    if (u < -1e-7 || u > 1 + 1e-7) continue;
    const Eigen::Vector3d q = to_origin.cross(ab);
    const double v = direction.dot(q) / determinant;
    if (v < -1e-7 || u + v > 1 + 1e-7) continue;
    const double t = ac.dot(q) / determinant;
    if (t > 0) nearest = std::min(nearest, t);
  }
  return std::isfinite(nearest) ? std::optional(nearest) : std::nullopt;
}

TEST(Tessellate, TrianglesLieWhereTheRaysMeetTheSolids) {
  const Scene scene = make_demo_scene(1);
  const Submesh mesh = joined(tessellate(scene, false, kEdge_m));
  int compared = 0;
  int beside = 0;
  for (int view = 0; view < 3; ++view) {
    const Pose T_world_depth = StationPath{6, 0}.at(2.0 * view);
    const ExactDepth exact = cast_depth(scene, kDepth, T_world_depth.inverse(), false);
    for (std::uint64_t i = 0; i < 60; ++i) {
      const int u = static_cast<int>(random_bits(1, i, 1) % 640);
      const int v = static_cast<int>(random_bits(1, i, 2) % 480);
      const auto t =
          nearest_triangle(mesh, T_world_depth.translation(), T_world_depth.linear() * kDepth.back_project(u, v, 1));
      const float depth = exact.depth(u, v);
      const bool round = depth > 0 && scene.solids[exact.solid(u, v) - 1u].shape == Solid::Shape::cylinder;
      if (round) continue;  // their chords lie below the mantle
      ++compared;
      if (!t.has_value() || depth == 0) {
        beside += t.has_value() == (depth > 0) ? 0 : 1;
      } else if (std::abs(*t - depth) > 0.0002) {
        ++beside;
      }
    }
  }
  EXPECT_GT(compared, 150);
  // A ray that grazes a stud may pass beside its 24-sided prism.
  EXPECT_LE(beside, 1);
}

TEST(Tessellate, PartsAreValidAndTheirEdgesKeepToTheLimit) {
  const Scene scene = make_demo_scene(1);
  const auto parts = tessellate(scene, false, kEdge_m);
  ASSERT_EQ(parts.size(), 4u);
  for (const SolidMesh& part : parts) {
    ASSERT_TRUE(validate(part.submesh)) << part.name;
    ASSERT_TRUE(part.submesh.has_colors());
    double longest = 0;
    for (const auto& [a, b, c] : part.submesh.triangles) {
      for (const auto& [i, j] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
        longest = std::max<double>(longest, (part.submesh.positions[i] - part.submesh.positions[j]).norm());
      }
    }
    EXPECT_LE(longest, kEdge_m * 1.00001) << part.name;
  }
}

TEST(Tessellate, SurfacesAreClosedAndFaceOutwards) {
  // The volume by the divergence theorem equals the solids' volumes only for closed surfaces with outward normals.
  for (const auto shape : {Solid::Shape::box, Solid::Shape::cylinder}) {
    Scene scene;
    Solid solid;
    solid.shape = shape;
    solid.size = {0.1, 0.1, 0.3};
    solid.object = "thing";
    solid.T_world_solid = make_pose({1, 2, 3}, Eigen::Quaterniond(0.5, 0.5, 0.1, 0.7));
    solid.texture = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return Rgb8{}; };
    scene.solids.push_back(solid);
    const auto parts = tessellate(scene, false, 0.02);
    double volume = 0;
    for (const auto& [a, b, c] : parts.at(0).submesh.triangles) {
      const auto p = [&](std::uint32_t i) { return Eigen::Vector3d(parts[0].submesh.positions[i].cast<double>()); };
      volume += p(a).dot(p(b).cross(p(c))) / 6;
    }
    const double expected = shape == Solid::Shape::box ? 0.003 : 3.14159265 * 0.0025 * 0.3;
    EXPECT_NEAR(volume, expected, 0.01 * expected);
  }
}

}  // namespace
}  // namespace meshloop::simulation
