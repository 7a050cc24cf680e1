// A wavy wall is captured in parts, each from another place: the parts must become one surface without an open border
// in between.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>

#include "kinect_camera.h"
#include "server/adjust/depth_buffer.h"
#include "server/adjust/proposal.h"
#include "server/compare/comparator.h"
#include "server/compare/region_tracker.h"
#include "snapshot_of.h"

namespace meshloop {
namespace {

const Camera kCamera{320, 240, 290, 290, 159.5, 119.5, {}};
const SensorModel kKinect{SensorModel::Kind::kinect1};
constexpr double kDegree = std::numbers::pi / 180;

double wall(double x, double y) {
  return 1.4 + 0.08 * std::sin(5 * x + 1) + 0.05 * std::cos(6 * y);
}

/// At 1 m from the wall's middle plane, sideways by x and y, rolled and turned.
Pose view(double x, double y, double roll_degrees, double yaw_degrees, double z = 0.4) {
  const Eigen::Quaterniond turn = Eigen::AngleAxisd{yaw_degrees * kDegree, Eigen::Vector3d::UnitY()} *
                                  Eigen::AngleAxisd{roll_degrees * kDegree, Eigen::Vector3d::UnitZ()};
  return make_pose({x, y, z}, turn);
}

// Where the ray meets the wall: each step takes away two thirds of the error and more.
double depth_of(const Pose& T_world_camera, int u, int v) {
  double z = 1;
  for (int i = 0; i < 25; ++i) {
    const Eigen::Vector3d p = T_world_camera * kCamera.back_project(u, v, z);
    z += 0.7 * (wall(p.x(), p.y()) - p.z());
  }
  return z;
}

/// One view of the wall, and what there is of it in the model.
struct Capture {
  Rig rig;
  RgbdFrame frame;
  Comparison comparison;
  RegionMap regions;
  Pose T_depth_world;
  Model model;

  Capture(Model modelled, const Pose& T_world_depth, double noise, unsigned seed)
      : T_depth_world{T_world_depth.inverse()}, model{std::move(modelled)} {
    rig.depth = rig.color = kCamera;
    rig.sensor = kKinect;
    frame.depth = DepthImage{kCamera.width, kCamera.height};
    frame.color = ColorImage{kCamera.width, kCamera.height, {120, 130, 140}};
    std::mt19937 random{seed};
    std::normal_distribution<double> normal;
    for (int v = 0; v < kCamera.height; ++v) {
      for (int u = 0; u < kCamera.width; ++u) {
        const double z = depth_of(T_world_depth, u, v);
        frame.depth(u, v) = static_cast<float>(z + noise * kKinect.sigma_z_m(z, 0) * normal(random));
      }
    }
    compare();
  }

  /// Nothing is measured there.
  void hide(int x0, int y0, int x1, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) frame.depth(x, y) = 0;
    }
    compare();
  }

  void compare() {
    adjust::DepthBuffer buffer{adjust::Window{0, 0, kCamera.width, kCamera.height}};
    for (std::uint32_t n = 0; n < model.nodes.size(); ++n) {
      const auto& node = model.nodes[n];
      const std::vector<std::uint32_t> what(node.submesh->triangles.size(), n + 1);
      draw(*node.submesh, what, T_depth_world * node.T_world_node, kCamera, buffer);
    }
    DepthImage expected{kCamera.width, kCamera.height};
    Image<std::uint32_t> nodes{kCamera.width, kCamera.height};
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        expected(x, y) = buffer.depth(x, y);
        nodes(x, y) = expected(x, y) > 0
                          ? buffer.what[static_cast<std::size_t>(y) * static_cast<std::size_t>(kCamera.width) +
                                        static_cast<std::size_t>(x)]
                          : 0;
      }
    }
    CompareInput input;
    input.model = &model;
    input.camera = kCamera;
    input.sensor = kKinect;
    input.pose.state = TrackState::tracking;
    input.pose.T_camera_world = T_depth_world;
    input.measured = &frame.depth;
    comparison = compare_on_cpu(input, expected, nodes);
    RegionOptions options;
    options.confirm_views = 1;
    RegionTracker tracker{options};
    regions = tracker.update(comparison, frame.depth, kCamera, T_depth_world);
    settle_labels(comparison, regions);
  }

  [[nodiscard]] Snapshot snapshot() const { return test::snapshot_of(*this); }
  [[nodiscard]] Model adjusted(const AdjustOptions& options) const {
    const auto merged = merge_edits(model, propose(snapshot(), 10 * (model.nodes.size() + 1), options));
    return *apply(model, merged->edits, model.revision + 1);
  }
};

/// Edges with a triangle on one side only, corners compared to the bit, well within the picture.
int open_edges(const Model& model, const Pose& T_depth_world) {
  using Point = std::array<float, 3>;
  std::map<std::pair<Point, Point>, int> left;
  const auto at = [](const Node& node, std::uint32_t i) {
    const Eigen::Vector3f p = node.T_world_node.cast<float>() * node.submesh->positions[i];
    return Point{p.x(), p.y(), p.z()};
  };
  for (const auto& node : model.nodes) {
    for (const auto& t : node.submesh->triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Point a = at(node, t[k]);
        const Point b = at(node, t[(k + 1) % 3]);
        left[std::minmax(a, b)] += a < b ? 1 : -1;
      }
    }
  }
  int count = 0;
  const auto is_inside = [&](const Point& p) {
    const Eigen::Vector3d seen = T_depth_world * Eigen::Vector3d{p[0], p[1], p[2]};
    return seen.z() > 0 && kCamera.contains(kCamera.project(seen), 8);
  };
  for (const auto& [edge, sides] : left) count += sides != 0 && is_inside(edge.first) && is_inside(edge.second) ? 1 : 0;
  return count;
}

struct Case {
  const char* name;
  Pose first;
  Pose second;
};
const std::vector<Case>& cases() {
  static const std::vector<Case> all{{"to the right", view(-0.3, 0, 0, 0), view(0.2, 0.02, 0, 0)},
                                     {"to the left, turned", view(0.3, 0, 0, 10), view(-0.2, 0.03, 0, -12)},
                                     {"below", view(0, -0.25, 0, 0), view(0.03, 0.2, 0, 5)},
                                     {"rolled", view(-0.3, 0, 20, 0), view(0.2, 0, -25, 8)},
                                     {"a corner", view(-0.25, -0.2, 5, 0), view(0.2, 0.15, -5, 0)},
                                     {"nearer", view(-0.35, 0, 0, 0), view(0.2, 0, 8, -6, 0.7)}};
  return all;
}

/// A first capture without neighbours, and the second one beside it.
struct TwoCaptures {
  Model first;
  Capture second;

  TwoCaptures(const Case& c, double noise, const AdjustOptions& options)
      : first{Capture{{}, c.first, noise, 1}.adjusted(options)}, second{first, c.second, noise, 2} {}
  [[nodiscard]] int open_edges(const Model& both) const { return meshloop::open_edges(both, second.T_depth_world); }
};

TEST(Stitch, LeavesNoOpenBorderBetweenCaptures) {
  for (const double noise : {0.0, 1.0}) {
    for (const auto& c : cases()) {
      AdjustOptions options;
      const TwoCaptures captures{c, noise, options};
      const Model both = captures.second.adjusted(options);
      EXPECT_GT(both.nodes.size(), captures.first.nodes.size()) << c.name;
      const int stitched = captures.open_edges(both);
      options.stitch = false;
      const int before = captures.open_edges(captures.second.adjusted(options));
      std::printf("noise %.0f, %s: %d of %d open edges are left\n", noise, c.name, stitched, before);
      EXPECT_GT(before, 200) << c.name;
      EXPECT_EQ(stitched, 0) << c.name;
    }
  }
}

// The first capture has lost most of its border vertices before the second one comes; its long edges are met by theirs.
TEST(Stitch, KeepsTheBorderWhenTrianglesAreFewer) {
  int left = 0;
  int before = 0;
  for (const auto& c : cases()) {
    AdjustOptions options;
    options.decimate_sigmas = 0.3;
    const TwoCaptures captures{c, 1, options};
    const Model both = captures.second.adjusted(options);
    const int stitched = captures.open_edges(both);
    EXPECT_LT(both.triangle_count(), 50'000U) << c.name;  // of 200,000
    options.stitch = false;
    const int apart = captures.open_edges(captures.second.adjusted(options));
    std::printf("decimated, %s: %d of %d open edges are left\n", c.name, stitched, apart);
    left += stitched;
    before += apart;
  }
  EXPECT_LT(100 * left, before);
}

TEST(Stitch, FillsAHole) {
  for (const double noise : {0.0, 1.0}) {
    Capture first{{}, view(0, 0, 0, 0), noise, 1};
    first.hide(100, 80, 210, 150);
    const Model with_hole = first.adjusted({});
    const Capture second{with_hole, view(0.05, 0.03, 10, 3), noise, 2};
    const int before = open_edges(with_hole, second.T_depth_world);
    const int after = open_edges(second.adjusted({}), second.T_depth_world);
    std::printf("noise %.0f: %d of %d open edges are left\n", noise, after, before);
    EXPECT_GT(before, 200);
    EXPECT_EQ(after, 0);
  }
}

TEST(Stitch, LeavesTheModelAndLonelyPatchesAsTheyAre) {
  const Model first = Capture{{}, cases()[0].first, 1, 1}.adjusted({});
  const Capture second{first, cases()[0].second, 1, 2};
  const Model both = second.adjusted({});
  for (const auto& node : first.nodes) EXPECT_EQ(both.find(node.id)->hash, node.hash);
  AdjustOptions apart;
  apart.stitch = false;
  const Model alone = Capture{{}, cases()[0].first, 1, 1}.adjusted(apart);
  ASSERT_EQ(alone.nodes.size(), first.nodes.size());
  for (std::size_t n = 0; n < alone.nodes.size(); ++n) EXPECT_EQ(alone.nodes[n].hash, first.nodes[n].hash);
}

/// Pixels in which two nodes lie within three sigma of each other.
int doubled_pixels(const Model& model, const Pose& T_depth_world) {
  std::vector<DepthImage> layers;
  for (const auto& node : model.nodes) {
    adjust::DepthBuffer buffer{adjust::Window{0, 0, kCamera.width, kCamera.height}};
    draw(*node.submesh, std::vector<std::uint32_t>(node.submesh->triangles.size(), 0),
         T_depth_world * node.T_world_node, kCamera, buffer);
    auto& layer = layers.emplace_back(kCamera.width, kCamera.height);
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) layer(x, y) = buffer.depth(x, y);
    }
  }
  int doubled = 0;
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      std::vector<float> depths;
      for (const auto& layer : layers) {
        if (layer(x, y) > 0) depths.push_back(layer(x, y));
      }
      std::sort(depths.begin(), depths.end());
      for (std::size_t i = 1; i < depths.size(); ++i) {
        if (depths[i] - depths[i - 1] > 3 * kKinect.sigma_z_m(static_cast<double>(depths[i]), 0)) continue;
        ++doubled;
        break;
      }
    }
  }
  return doubled;
}

// Seen from in between, so that pixels do not lie where they were measured.
TEST(Stitch, DoublesNoSurface) {
  int doubled = 0;
  for (const auto& c : cases()) {
    const Model both = TwoCaptures{c, 1, {}}.second.adjusted({});
    doubled += doubled_pixels(both, view(0.02, 0.01, 3, 2, 0.3).inverse());
  }
  std::printf("%d of %zu pixels are doubled\n", doubled, cases().size() * 320 * 240);
  EXPECT_LT(doubled, 10);
}

// What stands 5 cm before the wall leaves a hole in it as seen from the same place: the two do not meet.
TEST(Stitch, BuildsNoBridgeOverAStep) {
  for (const bool decimated : {false, true}) {
    AdjustOptions options;
    if (decimated) options.decimate_sigmas = 0.3;
    Capture first{{}, view(0, 0, 0, 0), 1, 1};
    first.hide(100, 80, 210, 150);
    Capture second{first.adjusted(options), view(0, 0, 0, 0), 1, 2};
    for (int y = 80; y < 150; ++y) {
      for (int x = 100; x < 210; ++x) second.frame.depth(x, y) -= 0.05f;
    }
    second.compare();
    const Model joined = second.adjusted(options);
    options.stitch = false;
    const Model apart = second.adjusted(options);
    ASSERT_EQ(joined.nodes.size(), apart.nodes.size());
    ASSERT_GT(joined.nodes.size(), second.model.nodes.size());
    for (std::size_t n = 0; n < joined.nodes.size(); ++n) EXPECT_EQ(joined.nodes[n].hash, apart.nodes[n].hash);
  }
}

}  // namespace
}  // namespace meshloop
