#include "moved_things.h"

#include <cmath>
#include <numbers>

#include "common/mesh/lattice.h"
#include "common/simulation/sensor.h"
#include "common/simulation/texture.h"
#include "kinect_camera.h"
#include "server/compare/comparator.h"
#include "server/compare/region_tracker.h"
#include "snapshot_of.h"

namespace meshloop::moved_things {
namespace {

using simulation::Scene;
using simulation::Solid;

constexpr double kEdge_m = 0.1;
/// Times finer: things that may move, whose vertices carry their colours.
constexpr double kDetail = 10;
constexpr double kDegree = std::numbers::pi / 180;

Solid solid(const char* name, Solid::Shape shape, const Eigen::Vector3d& size, const Pose& pose) {
  Solid made;
  made.name = made.object = name;
  made.shape = shape;
  made.size = size;
  made.T_world_solid = pose;
  made.modelled = true;
  return made;
}

Pose standing(double x, double y, double height, double turn_degrees) {
  return make_pose({x, y, height / 2},
                   Eigen::Quaterniond{Eigen::AngleAxisd{turn_degrees * kDegree, Eigen::Vector3d::UnitZ()}});
}

/// By position in Scene::solids: position in Model::nodes plus 1; 0 where it is not modelled.
std::vector<std::uint32_t> nodes_of(const Scene& scene, const Model& model) {
  std::vector<std::uint32_t> nodes;
  for (const auto& one : scene.solids) {
    std::uint32_t node = 0;
    for (std::uint32_t n = 0; one.modelled && n < model.nodes.size(); ++n) {
      if (model.nodes[n].name == one.object) node = n + 1;
    }
    nodes.push_back(node);
  }
  return nodes;
}

Comparison compare(const World& world, const Scene& before) {
  const auto exact = simulation::cast_depth(before, world.rig.depth, world.T_depth_world, true);
  const auto nodes = nodes_of(before, world.model);
  Image<std::uint32_t> node_index{world.rig.depth.width, world.rig.depth.height};
  for (std::size_t i = 0; i < node_index.size(); ++i) {
    const auto seen = exact.solid.pixels()[i];
    node_index.pixels()[i] = seen == 0 ? 0 : nodes[seen - 1U];
  }
  CompareInput input;
  input.model = &world.model;
  input.camera = world.rig.depth;
  input.sensor = world.rig.sensor;
  input.pose.state = TrackState::tracking;
  input.pose.T_camera_world = world.T_depth_world;
  input.measured = &world.frame.depth;
  return compare_on_cpu(input, exact.depth, node_index);
}

}  // namespace

Snapshot World::snapshot() const {
  return test::snapshot_of(*this);
}

std::unique_ptr<World> look(const Scene& before, const Scene& after, const View& view) {
  auto world = std::make_unique<World>();
  world->rig.depth = test::kinect_camera();
  world->rig.color = {640, 480, 525, 525, 319.5, 239.5, {}};
  world->rig.T_depth_color = make_pose({0.025, 0, 0}, Eigen::Quaterniond::Identity());
  world->rig.sensor = SensorModel{SensorModel::Kind::kinect1};
  world->T_depth_world = view.T_world_depth.inverse();
  for (auto& [name, submesh] : simulation::tessellate(before, true, kEdge_m)) {
    world->model.nodes.push_back(make_node(world->model.nodes.size() + 1, name, snap_to_lattice(submesh)));
  }
  const auto exact = simulation::cast_depth(after, world->rig.depth, world->T_depth_world, false);
  world->frame.depth = simulation::measure(exact, world->rig.depth, world->rig.sensor, {view.noise, view.seed});
  const Pose T_color_world = world->rig.T_depth_color.inverse() * world->T_depth_world;
  world->frame.color = simulation::cast_color(after, world->rig.color, T_color_world, 1);
  simulation::add_color_noise(world->frame.color, 2, view.seed);
  world->comparison = compare(*world, before);
  RegionOptions options;
  options.confirm_views = 1;
  RegionTracker tracker{options};
  world->regions = tracker.update(world->comparison, world->frame.depth, world->rig.depth, world->T_depth_world);
  settle_labels(world->comparison, world->regions);
  return world;
}

Solid box_on_table(const Eigen::Vector3d& size, double x, double y, double turn_degrees, bool has_print,
                   std::uint64_t seed) {
  Solid box = solid("box", Solid::Shape::box, size, standing(x, y, size.z(), turn_degrees));
  box.mesh_detail = kDetail;
  box.texture = has_print ? simulation::wrapping_paper(size, seed) : simulation::plain({170, 120, 80}, size, seed);
  return box;
}

Solid can_on_table(double diameter, double height, double x, double y) {
  Solid can = solid("box", Solid::Shape::cylinder, {diameter, diameter, height}, standing(x, y, height, 0));
  can.texture = simulation::plain({90, 130, 160}, can.size, 5);
  return can;
}

Scene table(bool has_prints) {
  Scene scene;
  const auto add = [&](const char* name, const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
    Solid one = solid(name, Solid::Shape::box, size, make_pose(center, Eigen::Quaterniond::Identity()));
    one.texture = has_prints ? simulation::wood({190, 150, 100}, {120, 80, 50}, scene.solids.size())
                             : simulation::plain({180, 180, 175}, size, scene.solids.size());
    scene.solids.push_back(std::move(one));
  };
  add("table", {1.8, 1.2, 0.04}, {0, 0, -0.02});
  add("floor", {6, 6, 0.1}, {0, 0, -0.75});
  add("wall", {6, 0.1, 4}, {0, 1.2, 1.2});
  add("crate", {0.2, 0.12, 0.18}, {-0.45, 0.42, 0.09});
  add("tin", {0.1, 0.1, 0.15}, {0.42, 0.4, 0.075});
  scene.background = [](const Eigen::Vector3d&) { return Rgb8{90, 90, 90}; };
  return scene;
}

Pose camera_at(double distance_m, double azimuth_degrees, double elevation_degrees) {
  const double azimuth = azimuth_degrees * kDegree;
  const double elevation = elevation_degrees * kDegree;
  const Eigen::Vector3d target{0, 0, 0.05};
  const Eigen::Vector3d back{std::sin(azimuth) * std::cos(elevation), -std::cos(azimuth) * std::cos(elevation),
                             std::sin(elevation)};
  return look_at(target + distance_m * back, target, Eigen::Vector3d::UnitZ());
}

}  // namespace meshloop::moved_things
