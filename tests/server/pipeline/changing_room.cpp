#include "changing_room.h"

#include <fmt/format.h>

#include "common/simulation/sensor.h"
#include "server/compare/comparator.h"
#include "server/compare/region_tracker.h"

namespace meshloop::test {
namespace {

constexpr int kPlaces = 4;
constexpr double kWall_m = 2;
/// Few large triangles, which removals have to cut.
constexpr double kEdge_m = 6;
constexpr Camera kCamera{128, 96, 117, 117, 63.5, 47.5, {}};

simulation::Solid solid(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& centre) {
  simulation::Solid solid;
  solid.name = solid.object = name;
  solid.size = size;
  solid.T_world_solid.translation() = centre;
  solid.texture = [](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
    return Rgb8{static_cast<std::uint8_t>(100 * std::abs(p.x())), 90, static_cast<std::uint8_t>(100 * std::abs(p.y()))};
  };
  solid.modelled = true;
  return solid;
}

ColorImage color_image() {
  ColorImage image{kCamera.width, kCamera.height};
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x)
      image(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 9};
  }
  return image;
}

}  // namespace

ChangingRoom::ChangingRoom(unsigned seed) : random_{seed}, stands_(kPlaces), side_m_(kPlaces, 0.3) {
  rig_.color = rig_.depth = kCamera;
  rig_.sensor = SensorModel::constant(0.001).value();
  stands_[seed % kPlaces] = true;
}

simulation::Scene ChangingRoom::scene() const {
  simulation::Scene scene;
  scene.background = [](const Eigen::Vector3d&) { return Rgb8{}; };
  scene.solids.push_back(solid("wall", {4, 4, 0.1}, {0, 0, kWall_m + 0.05}));
  for (std::size_t place = 0; place < stands_.size(); ++place) {
    if (!stands_[place]) continue;
    const double side = side_m_[place];
    const Eigen::Vector3d centre{place % 2 == 0 ? -0.4 : 0.4, place < 2 ? -0.3 : 0.3, kWall_m - 0.4};
    scene.solids.push_back(solid(fmt::format("box {}", place), {side, side, side}, centre));
  }
  return scene;
}

std::vector<Edit> ChangingRoom::model_from(NodeId id) const {
  std::vector<Edit> edits;
  for (auto& [name, submesh] : simulation::tessellate(scene(), true, kEdge_m)) {
    edits.emplace_back(AddNode{make_node(id++, name, std::move(submesh))});
  }
  return edits;
}

void ChangingRoom::change() {
  const auto place = random_() % kPlaces;
  if (stands_[place] && random_() % 2 == 0) {
    side_m_[place] = 0.2 + 0.02 * static_cast<double>(random_() % 10);
  } else {
    stands_[place] = !stands_[place];
  }
}

ChangingRoom::Look ChangingRoom::look(const SceneStore& store) {
  Look look;
  RgbdFrame& frame = look.tracked.frame;
  TrackedPose& pose = look.tracked.depth_pose;
  frame.index = looks_++;
  frame.depth_timestamp_s = frame.color_timestamp_s = pose.timestamp_s = frame.index / 30.0;
  const double x_m = 0.01 * static_cast<double>(random_() % 20);
  pose.T_camera_world = look_at({x_m, 0.1, 0}, {0, 0, kWall_m}, {0, -1, 0}).inverse();
  pose.state = TrackState::tracking;
  pose.covariance = PoseCovariance::Identity() * 1e-8;
  const auto exact = simulation::cast_depth(scene(), kCamera, pose.T_camera_world, false, 1);
  frame.depth = simulation::measure(exact, kCamera, rig_.sensor, {1, random_()});
  frame.color = color_image();
  const auto model = store.model();
  CompareInput input{.model = model.get(),
                     .camera = kCamera,
                     .sensor = rig_.sensor,
                     .pose = pose,
                     .measured = &frame.depth,
                     .threshold = {Threshold::Kind::fixed, 0.01}};
  DepthImage expected{kCamera.width, kCamera.height};
  Image<std::uint32_t> node_index{kCamera.width, kCamera.height};
  render_on_cpu(*model, kCamera, pose.T_camera_world, expected, node_index);
  Examination examination;
  examination.comparison = compare_on_cpu(input, expected, node_index);
  RegionOptions options;
  options.confirm_views = 1;
  examination.regions =
      RegionTracker{options}.update(examination.comparison, frame.depth, kCamera, pose.T_camera_world);
  settle_labels(examination.comparison, examination.regions);
  look.changes = propose_changes(look.tracked, examination, {}, rig_, store, {});
  return look;
}

}  // namespace meshloop::test
