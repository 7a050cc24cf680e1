#include "boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/simulation/scene.h"
#include "common/simulation/sensor.h"
#include "snapshot_of.h"

namespace meshloop::boxes {
namespace {

// Slab test; nothing when the ray misses.
double distance_to(const Box& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  double from = 0;
  double to = std::numeric_limits<double>::max();
  for (int k = 0; k < 3; ++k) {
    const double a = (box.low[k] - origin[k]) / ray[k];
    const double b = (box.high[k] - origin[k]) / ray[k];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to ? from : std::numeric_limits<double>::max();
}

Label label_of(float measured, float expected, double threshold) {
  if (measured == 0) return Label::unmeasured;
  if (expected == 0) return Label::unmodelled;
  const double difference = static_cast<double>(measured) - static_cast<double>(expected);
  if (std::abs(difference) <= threshold) return Label::agrees;
  return difference < 0 ? Label::closer : Label::farther;
}

void add_face(Submesh& mesh, const Eigen::Vector3d& corner, const Eigen::Vector3d& along, const Eigen::Vector3d& up,
              double edge) {
  const auto across = static_cast<std::uint32_t>(std::max(1.0, std::ceil(along.norm() / edge - 1e-9)));
  const auto rows = static_cast<std::uint32_t>(std::max(1.0, std::ceil(up.norm() / edge - 1e-9)));
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= across; ++x) {
      mesh.positions.push_back((corner + along * x / across + up * y / rows).cast<float>());
    }
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < across; ++x) {
      const std::uint32_t i = first + y * (across + 1) + x;
      mesh.triangles.push_back({i, i + 1, i + across + 1});
      mesh.triangles.push_back({i + 1, i + across + 2, i + across + 1});
    }
  }
}

void add_noise(DepthImage& depth, const WorldOptions& options) {
  if (options.noise == 0) return;
  std::mt19937 random{options.seed};
  std::normal_distribution<double> gauss;
  for (auto& z : depth.pixels()) {
    if (z > 0) z += static_cast<float>(gauss(random) * options.noise * options.sensor.sigma_z_m(z, 0));
  }
}

void fill(World& world, int x, int y, ChangeKind kind, Region& region) {
  std::vector<Eigen::Vector2i> open{{x, y}};
  while (!open.empty()) {
    const Eigen::Vector2i p = open.back();
    open.pop_back();
    const auto& labels = world.comparison.labels;
    if (p.x() < 0 || p.y() < 0 || p.x() >= labels.width() || p.y() >= labels.height()) continue;
    if (world.regions.ids(p.x(), p.y()) != 0 || kind_of(labels(p.x(), p.y())) != kind) continue;
    world.regions.ids(p.x(), p.y()) = region.id;
    region.pixel_box.extend(p);
    ++region.pixels;
    const float d = world.comparison.difference_m(p.x(), p.y());
    if (std::abs(d) > std::abs(region.max_difference_m)) region.max_difference_m = static_cast<double>(d);
    for (const auto& step : {Eigen::Vector2i{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) open.push_back(p + step);
  }
}

void find_regions(World& world) {
  const auto& labels = world.comparison.labels;
  world.regions.ids = Image<RegionId>{labels.width(), labels.height()};
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      const ChangeKind kind = kind_of(labels(x, y));
      if (kind == ChangeKind::none || world.regions.ids(x, y) != 0) continue;
      Region region;
      region.id = static_cast<RegionId>(world.regions.regions.size() + 1);
      region.kind = kind;
      region.confirmed = true;
      fill(world, x, y, kind, region);
      world.regions.regions.push_back(region);
    }
  }
}

void compare(World& world, const WorldOptions& options) {
  const Camera& camera = world.rig.depth;
  std::vector<Box> modelled;
  std::vector<std::uint32_t> node_position;
  for (const auto& box : world.boxes) {
    if (box.node == 0) continue;
    modelled.push_back(box);
    node_position.push_back(static_cast<std::uint32_t>(world.model.find(box.node) - world.model.nodes.data()) + 1);
  }
  auto seen = cast(modelled, camera, world.T_depth_world);
  Comparison& c = world.comparison;
  c.expected = std::move(seen.depth);
  c.node_index = std::move(seen.box);
  c.labels = Image<Label>{camera.width, camera.height};
  c.difference_m = Image<float>{camera.width, camera.height, std::numeric_limits<float>::quiet_NaN()};
  c.threshold_m = Image<float>{camera.width, camera.height, static_cast<float>(options.threshold_m)};
  for (std::size_t i = 0; i < c.labels.size(); ++i) {
    const float measured = world.frame.depth.pixels()[i];
    const float expected = c.expected.pixels()[i];
    auto& node = c.node_index.pixels()[i];
    if (node != 0) node = node_position[node - 1];
    auto& threshold = c.threshold_m.pixels()[i];
    if (options.threshold_sigmas > 0 && expected > 0) {
      const double sigma_m = options.sensor.sigma_z_m(static_cast<double>(expected), 0);
      threshold = static_cast<float>(options.threshold_sigmas * sigma_m);
    }
    c.labels.pixels()[i] = label_of(measured, expected, static_cast<double>(threshold));
    if (measured > 0 && expected > 0) c.difference_m.pixels()[i] = measured - expected;
  }
}

ColorImage cast_color(const std::vector<Box>& boxes, const Camera& camera, const Pose& T_camera_world,
                      const WorldOptions& options) {
  const auto seen = cast(boxes, camera, T_camera_world);
  const Pose T_world_camera = T_camera_world.inverse();
  ColorImage color{camera.width, camera.height};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const float z = seen.depth(x, y);
      if (z > 0) color(x, y) = options.paint(T_world_camera * camera.back_project(x, y, static_cast<double>(z)));
    }
  }
  return color;
}

}  // namespace

Cast cast(const std::vector<Box>& boxes, const Camera& camera, const Pose& T_camera_world) {
  Cast result{DepthImage{camera.width, camera.height}, Image<std::uint32_t>{camera.width, camera.height}};
  const Pose T_world_camera = T_camera_world.inverse();
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray = T_world_camera.linear() * camera.back_project(x, y, 1);
      double nearest = 100;
      for (std::size_t b = 0; b < boxes.size(); ++b) {
        const double z = distance_to(boxes[b], T_world_camera.translation(), ray);
        if (z >= nearest) continue;
        nearest = z;
        result.depth(x, y) = static_cast<float>(z);
        result.box(x, y) = static_cast<std::uint32_t>(b + 1);
      }
    }
  }
  return result;
}

DepthImage measure(const std::vector<Box>& boxes, const Camera& camera, const Pose& T_camera_world,
                   const SensorModel& sensor, unsigned seed) {
  simulation::Scene scene;
  for (const auto& box : boxes) {
    simulation::Solid solid;
    solid.size = box.high - box.low;
    solid.T_world_solid.translation() = (box.low + box.high) / 2;
    scene.solids.push_back(solid);
  }
  const auto exact = simulation::cast_depth(scene, camera, T_camera_world, false);
  return simulation::measure(exact, camera, sensor, {1, seed});
}

Submesh tessellate(const Box& box) {
  Submesh mesh;
  const Eigen::Vector3d size = box.high - box.low;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d along = size[(k + 1) % 3] * Eigen::Vector3d::Unit((k + 1) % 3);
    const Eigen::Vector3d up = size[(k + 2) % 3] * Eigen::Vector3d::Unit((k + 2) % 3);
    add_face(mesh, box.low, up, along, box.edge_m);
    add_face(mesh, box.low + size[k] * Eigen::Vector3d::Unit(k), along, up, box.edge_m);
  }
  return mesh;
}

Snapshot World::snapshot() const {
  return test::snapshot_of(*this);
}

Region World::region(ChangeKind kind) const {
  Region largest;
  for (const auto& r : regions.regions) {
    if (r.kind == kind && r.pixels > largest.pixels) largest = r;
  }
  return largest;
}

std::unique_ptr<World> make_world(std::vector<Box> boxes, const Pose& T_world_depth, const WorldOptions& options) {
  auto world = std::make_unique<World>();
  world->boxes = std::move(boxes);
  world->rig.depth = options.depth;
  world->rig.color = options.color;
  world->rig.T_depth_color = options.T_depth_color;
  world->rig.sensor = options.sensor;
  world->T_depth_world = T_world_depth.inverse();
  std::vector<Box> real;
  for (const auto& box : world->boxes) {
    if (box.real) real.push_back(box);
    if (box.node != 0) world->model.nodes.push_back(make_node(box.node, "box", tessellate(box)));
  }
  world->truth = cast(real, options.depth, world->T_depth_world).depth;
  world->frame.depth = world->truth;
  add_noise(world->frame.depth, options);
  if (options.with_all_faults) {
    world->frame.depth = measure(real, options.depth, world->T_depth_world, options.sensor, options.seed);
  }
  const Pose T_color_world = options.T_depth_color.inverse() * world->T_depth_world;
  world->frame.color = cast_color(real, options.color, T_color_world, options);
  compare(*world, options);
  find_regions(*world);
  return world;
}

}  // namespace meshloop::boxes
