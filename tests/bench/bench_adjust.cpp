// Time to make a submesh from a depth frame (the paper: 9, 22 and 80 ms for these three sizes), and to find what a
// removal takes from a model.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "server/adjust/depth_grid.h"
#include "server/adjust/edge_rings.h"
#include "server/adjust/grid_mesh.h"
#include "server/adjust/joint_poses.h"
#include "server/adjust/moved_things.h"
#include "server/adjust/proposal.h"
#include "server/adjust/registration.h"
#ifdef MESHLOOP_PCL
#include "pcl_mesh.h"
#endif

namespace meshloop {
namespace {

/// Everything in the picture is new: a wavy wall between 1.5 and 2.5 m, with a Kinect's noise, a printed picture, and
/// nothing measured in one pixel of a hundred.
struct NewWall {
  Rig rig;
  RgbdFrame frame;
  Model model;
  Comparison comparison;
  RegionMap regions;

  NewWall(int width, int height) {
    rig.depth = {width, height, 0.9 * width, 0.9 * width, (width - 1) / 2.0, (height - 1) / 2.0, {}};
    rig.color = {640, 480, 525, 525, 319.5, 239.5, {}};
    rig.T_depth_color = make_pose({0.025, 0, 0}, Eigen::Quaterniond::Identity());
    rig.sensor = SensorModel{SensorModel::Kind::kinect1};
    frame.depth = DepthImage{width, height};
    frame.color = ColorImage{640, 480};
    std::mt19937 random{1};
    for (auto& pixel : frame.color.pixels()) {
      const auto level = [&] { return static_cast<std::uint8_t>(random() & 0xff); };
      pixel = {level(), level(), level()};
    }
    std::normal_distribution<float> noise;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const float z = 2 + 0.5f * std::sin(6.0f * static_cast<float>(x) / static_cast<float>(width));
        const auto sigma = static_cast<float>(rig.sensor.sigma_z_m(z, 0));
        frame.depth(x, y) = random() % 100 == 0 ? 0.0f : z + sigma * noise(random);
      }
    }
    comparison.labels = Image<Label>{width, height, Label::unmodelled};
    comparison.difference_m = Image<float>{width, height};
    comparison.expected = DepthImage{width, height};
    comparison.node_index = Image<std::uint32_t>{width, height};
    comparison.threshold_m = Image<float>{width, height, 0.01f};
    regions.ids = Image<RegionId>{width, height, 1};
    Region region;
    region.id = 1;
    region.kind = ChangeKind::insertion;
    region.confirmed = true;
    regions.regions = {region};
  }

  [[nodiscard]] Snapshot snapshot() const {
    Snapshot s;
    s.model = &model;
    s.frame = &frame;
    s.rig = &rig;
    s.depth_pose.state = TrackState::tracking;
    s.depth_pose.covariance = 1e-4 * PoseCovariance::Identity();
    s.comparison = &comparison;
    s.regions = &regions;
    return s;
  }
};

void insert_patch(benchmark::State& state) {
  const NewWall wall{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  AdjustOptions options;
  options.flatten = state.range(2) != 0;
  std::size_t triangles = 0;
  for (auto _ : state) triangles = insertion_patch(wall.snapshot(), 1, options).triangles.size();
  state.counters["measurements"] = static_cast<double>(wall.frame.depth.size());
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(insert_patch)
    ->ArgNames({"width", "height", "flatten"})
    ->ArgsProduct({{176}, {144}, {0, 1}})
    ->ArgsProduct({{320}, {240}, {0, 1}})
    ->ArgsProduct({{640}, {480}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

/// The triangles alone, from depths that were chosen and smoothed already.
void triangulate(benchmark::State& state) {
  const NewWall wall{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  auto grid = adjust::select_patch(wall.comparison, wall.frame.depth, {}, wall.regions.ids, 1, wall.rig.sensor);
  adjust::smooth(grid, wall.frame.depth);
  const AdjustOptions options;
  std::size_t triangles = 0;
  for (auto _ : state) {
    auto mesh = adjust::join_pixels(grid, wall.rig.depth, options.discontinuity_sigmas, {});
    adjust::drop_small_pieces(mesh, options.min_patch_triangles);
    triangles = adjust::triangles_of(mesh, adjust::number_vertices(mesh)).size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(triangulate)->ArgNames({"width", "height"})->Args({640, 480})->Unit(benchmark::kMillisecond);

#ifdef MESHLOOP_PCL
/// The same picture: the triangles alone, from points that are there already.
void pcl_triangulate(benchmark::State& state) {
  const NewWall wall{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  PclMesh pcl;
  pcl.set_points(wall.frame.depth, wall.rig.depth, wall.frame.color);
  std::size_t triangles = 0;
  for (auto _ : state) triangles = pcl.triangulate(0.1f);
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(pcl_triangulate)->ArgNames({"width", "height"})->Args({640, 480})->Unit(benchmark::kMillisecond);

/// From the picture to arrays as an insertion's; without a look at visibility, and without pieces that are too small.
void pcl_insert(benchmark::State& state) {
  const NewWall wall{static_cast<int>(state.range(0)), static_cast<int>(state.range(1))};
  const auto sigma_m = static_cast<float>(wall.rig.sensor.sigma_z_m(2, 0));
  std::size_t triangles = 0;
  for (auto _ : state) {
    PclMesh pcl;
    pcl.set_points(wall.frame.depth, wall.rig.depth, wall.frame.color);
    if (state.range(2) != 0) pcl.smooth(2 * sigma_m);
    pcl.triangulate(0.1f);
    triangles = pcl.arrays().triangles.size();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(pcl_insert)
    ->ArgNames({"width", "height", "smooth"})
    ->ArgsProduct({{640}, {480}, {0, 1}})
    ->Unit(benchmark::kMillisecond);
#else
void pcl_insert(benchmark::State& state) {
  state.SkipWithError("PCL was not installed when this was built (libpcl-dev)");
}
BENCHMARK(pcl_insert);
#endif

/// A wavy wall that is expected 5 mm from where it is measured.
void refine_pose_of_a_frame(benchmark::State& state) {
  NewWall wall{640, 480};
  wall.comparison.expected = wall.frame.depth;
  wall.comparison.node_index = Image<std::uint32_t>{640, 480, 1};
  for (float& z : wall.frame.depth.pixels()) z += 0.005f;
  Registration found;
  for (auto _ : state) found = refine_pose(wall.snapshot());
  state.counters["left_mm"] = 1000 * found.after_m;
}
BENCHMARK(refine_pose_of_a_frame)->Unit(benchmark::kMillisecond);

/// Eight frames of a Kinect, of a wavy wall that the model has on its left half alone, each with a pose of its own.
void refine_poses_of_eight_frames(benchmark::State& state) {
  NewWall wall{640, 480};
  wall.comparison.expected = wall.frame.depth;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 320; ++x) wall.comparison.node_index(x, y) = 1;
  }
  std::mt19937 random{1};
  std::normal_distribution<float> noise;
  std::vector<DepthImage> depths(8, wall.frame.depth);
  std::vector<PosedDepth> frames;
  for (auto& depth : depths) {
    for (float& z : depth.pixels()) z += noise(random) * static_cast<float>(wall.rig.sensor.sigma_z_m(2, 0));
    Twist error;
    for (double& value : error) value = 0.003 * static_cast<double>(noise(random));
    frames.push_back({&depth, exp(error), 1e-5 * PoseCovariance::Identity(), nullptr});
  }
  frames.front().comparison = &wall.comparison;
  JointPoses found;
  for (auto _ : state) found = refine_poses(frames, wall.rig.depth, wall.rig.sensor);
  state.counters["pairs"] = found.between_frames;
  state.counters["before_mm"] = 1000 * found.before.frames_m;
  state.counters["after_mm"] = 1000 * found.after.frames_m;
  state.SetLabel(found.refused.value_or(""));
}
BENCHMARK(refine_poses_of_eight_frames)->Unit(benchmark::kMillisecond);

/// Things on a table, as they are.
void look_for_edge_rings(benchmark::State& state) {
  const auto scene = moved_things::table(false);
  const auto world = moved_things::look(scene, scene, {moved_things::camera_at(1.1, 20, 35), 1, 1});
  int outlines = 0;
  for (auto _ : state) {
    outlines = find_edge_rings(world->comparison, world->frame.depth, world->rig.depth, world->rig.sensor).outlines;
  }
  state.counters["outlines"] = outlines;
}
BENCHMARK(look_for_edge_rings)->Unit(benchmark::kMillisecond);

void propose_whole_frame(benchmark::State& state) {
  const NewWall wall{640, 480};
  for (auto _ : state) benchmark::DoNotOptimize(propose(wall.snapshot(), 1, {}).size());
}
BENCHMARK(propose_whole_frame)->Unit(benchmark::kMillisecond);

// A sheet of n x n vertices at 1 m, seen through to a wall at 3 m.
void remove_sheet(benchmark::State& state) {
  NewWall wall{640, 480};
  const auto n = static_cast<std::uint32_t>(state.range(0));
  Submesh sheet;
  for (std::uint32_t y = 0; y < n; ++y) {
    for (std::uint32_t x = 0; x < n; ++x) {
      const auto at = [n](std::uint32_t i) {
        return 0.6f * (static_cast<float>(i) / static_cast<float>(n - 1) - 0.5f);
      };
      sheet.positions.emplace_back(at(x), at(y), 1.0f);
      if (x + 1 == n || y + 1 == n) continue;
      const std::uint32_t i = y * n + x;
      sheet.triangles.push_back({i, i + n, i + 1});
      sheet.triangles.push_back({i + 1, i + n, i + n + 1});
    }
  }
  wall.model.nodes.push_back(make_node(1, "sheet", std::move(sheet)));
  wall.frame.depth = DepthImage{640, 480, 3.0f};
  wall.comparison.labels = Image<Label>{640, 480, Label::farther};
  wall.comparison.expected = DepthImage{640, 480, 1.0f};
  wall.comparison.node_index = Image<std::uint32_t>{640, 480, 1};
  wall.regions.regions[0].kind = ChangeKind::removal;
  for (auto _ : state) benchmark::DoNotOptimize(propose(wall.snapshot(), 2, {}).size());
  state.counters["triangles"] = static_cast<double>(wall.model.triangle_count());
}
// An opening of 320 x 240 pixels in a wall of two triangles at 1 m.
void cut_opening(benchmark::State& state) {
  NewWall wall{640, 480};
  Submesh sheet;
  sheet.positions = {{-2, -2, 1}, {2, -2, 1}, {2, 2, 1}, {-2, 2, 1}};
  sheet.triangles = {{0, 2, 1}, {0, 3, 2}};
  wall.model.nodes.push_back(make_node(1, "wall", std::move(sheet)));
  wall.frame.depth = DepthImage{640, 480, 1.0f};
  wall.comparison.labels = Image<Label>{640, 480, Label::agrees};
  wall.comparison.expected = DepthImage{640, 480, 1.0f};
  wall.comparison.node_index = Image<std::uint32_t>{640, 480, 1};
  wall.regions.ids = Image<RegionId>{640, 480};
  wall.regions.regions[0].kind = ChangeKind::removal;
  for (int y = 120; y < 360; ++y) {
    for (int x = 160; x < 480; ++x) {
      wall.frame.depth(x, y) = 3;
      wall.comparison.labels(x, y) = Label::farther;
      wall.regions.ids(x, y) = 1;
    }
  }
  std::size_t triangles = 0;
  for (auto _ : state) triangles = propose(wall.snapshot(), 2, {}).at(0).triangles_added;
  state.counters["triangles"] = static_cast<double>(triangles);
}
BENCHMARK(cut_opening)->Unit(benchmark::kMillisecond);

// A box of a few thousand triangles on a table, moved by 12 cm and turned by 30 degrees, or swapped for another one.
void look_for_moves(benchmark::State& state) {
  using namespace moved_things;
  const bool swapped = state.range(0) == 1;
  const Eigen::Vector3d size{0.22, 0.15, swapped ? 0.16 : 0.12};
  simulation::Scene before = table(false);
  simulation::Scene after = before;
  before.solids.push_back(box_on_table({0.22, 0.15, 0.12}, 0, 0, 20, state.range(1) == 1, 1));
  after.solids.push_back(box_on_table(size, 0.1, 0.06, 50, state.range(1) == 1, swapped ? 2 : 1));
  const auto world = look(before, after, {camera_at(1.1, 20, 35), 1, 1});
  AdjustOptions options;
  options.moves = state.range(2) == 1;
  std::size_t moves = 0;
  for (auto _ : state) {
    const auto proposals = propose(world->snapshot(), 50, options);
    moves = 0;
    for (const auto& proposal : proposals) moves += proposal.move ? 1 : 0;
  }
  state.counters["moves"] = static_cast<double>(moves);
  state.counters["triangles"] = static_cast<double>(world->model.triangle_count());
}
BENCHMARK(look_for_moves)
    ->ArgNames({"swapped", "print", "search"})
    ->ArgsProduct({{0, 1}, {0, 1}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

BENCHMARK(remove_sheet)->Arg(100)->Arg(700)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace meshloop
