// Things of a few large triangles with a texture: their print tells them apart as colours at vertices do.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "common/mesh/lattice.h"
#include "common/simulation/sensor.h"
#include "moved_things.h"
#include "server/adjust/move_color.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using moved_things::box_on_table;
using moved_things::camera_at;
using simulation::Scene;
using simulation::Solid;

const Eigen::Vector3d kSize{0.24, 0.16, 0.12};

Scene with(Scene scene, const Solid& solid) {
  scene.solids.push_back(solid);
  return scene;
}

/// The faces of a box that a camera sees, two triangles each, with what the camera sees there.
Submesh seen_faces(const Scene& scene, const Solid& box, const Rig& rig, const Pose& T_color_world) {
  std::array<Eigen::Vector3f, 8> corners;
  for (unsigned i = 0; i < 8; ++i) {
    const Eigen::Vector3d share{i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5};
    corners[i] = on_lattice((box.T_world_solid * share.cwiseProduct(box.size)).cast<float>());
  }
  Submesh faces;
  faces.positions.assign(corners.begin(), corners.end());
  faces.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const Eigen::Vector3f eye = T_color_world.inverse().translation().cast<float>();
  std::vector<bool> is_seen;
  for (const auto& [a, b, c] : faces.triangles) {
    const Eigen::Vector3f normal = (corners[b] - corners[a]).cross(corners[c] - corners[a]);
    is_seen.push_back(normal.dot(eye - corners[a]) > 0);
  }
  faces.texture = test::must_project(simulation::cast_color(scene, rig.color, T_color_world, 1),
                                     test::projection_of(rig.color, T_color_world), 85);
  return keep_triangles(faces, is_seen);
}

/// The box as a node of a few triangles, and the picture after it was moved.
std::unique_ptr<moved_things::World> look_after(const Solid& before, const Solid& after) {
  const Scene old_scene = with(moved_things::table(true), before);
  auto world = moved_things::look(old_scene, with(moved_things::table(true), after), {camera_at(1.1, 25, 35), 1, 3});
  const Pose T_color_world = world->rig.T_depth_color.inverse() * world->T_depth_world;
  for (auto& node : world->model.nodes) {
    if (node.name != "box") continue;
    node = make_node(node.id, "box", seen_faces(old_scene, before, world->rig, T_color_world));
  }
  return world;
}

const Solid kBox = box_on_table(kSize, 0, 0, 20, true, 1);
const Solid kMoved = box_on_table(kSize, 0.09, 0.05, 20, true, 1);
const Eigen::Vector3d kWay{0.09, 0.05, 0};

TEST(MovedTexture, ABoxOfSixTrianglesIsFound) {
  const auto world = look_after(kBox, kMoved);
  auto moves = propose(world->snapshot(), 100, {});
  std::erase_if(moves, [](const Proposal& proposal) { return !proposal.move; });
  ASSERT_EQ(moves.size(), 1U);
  const Eigen::Vector3d middle = kBox.T_world_solid.translation();
  EXPECT_LT((moves[0].move->T_world_new_old * middle - middle - kWay).norm(), 0.003);
}

/// How well the box's print fits the picture, when it is taken to stand `off` beside where it does.
std::optional<double> agreement(const moved_things::World& world, const Eigen::Vector3d& off) {
  const Snapshot snapshot = world.snapshot();
  const adjust::MoveScene scene{snapshot};
  std::size_t position = 0;
  while (world.model.nodes[position].name != "box") ++position;
  const Node& node = world.model.nodes[position];
  const auto part = adjust::make_part(node, position, std::vector<bool>(node.submesh->triangles.size(), true));
  const Pose T_world_new = make_pose(kWay + off, Eigen::Quaterniond::Identity());
  const adjust::ColorLookup seen{snapshot};
  return adjust::color_agreement(scene, part, adjust::colors_of(part, seen), world.T_depth_world * T_world_new);
}

TEST(MovedTexture, ItsPrintFitsWhereItStandsAndNotBeside) {
  const auto world = look_after(kBox, kMoved);
  const auto there = agreement(*world, {0, 0, 0});
  ASSERT_TRUE(there);
  EXPECT_GT(*there, 0.9);
  for (const Eigen::Vector3d& off : {Eigen::Vector3d{0.015, 0, 0}, {-0.015, 0, 0}, {0, 0.015, 0}}) {
    const auto beside = agreement(*world, off);
    ASSERT_TRUE(beside);
    EXPECT_LT(*beside, 0.75) << off.transpose();
  }
}

TEST(MovedTexture, APictureThatCannotBeDecodedSaysNothing) {
  const auto world = look_after(kBox, kMoved);
  for (auto& node : world->model.nodes) {
    if (node.name != "box") continue;
    Submesh damaged = *node.submesh;
    auto texture = std::make_shared<ProjectedTexture>(*damaged.texture);
    texture->jpeg.resize(texture->jpeg.size() / 2);
    damaged.texture = std::move(texture);
    node = make_node(node.id, "box", damaged);
  }
  EXPECT_FALSE(agreement(*world, {0, 0, 0}));
}

}  // namespace
}  // namespace meshloop
