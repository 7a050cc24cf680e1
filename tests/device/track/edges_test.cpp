// Edges of the model's shape, and the pose from points and edges.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "device/track/edge_match.h"
#include "device/track/pose_solver.h"

namespace meshloop {
namespace {

Camera camera() {
  return {96, 64, 80, 80, 47.5, 31.5, {}};
}

/// Depth of a surface whose inverse depth is given for each column.
template <class InverseDepth>
RenderedView view_of_columns(const InverseDepth& inverse_depth) {
  RenderedView view;
  view.camera = camera();
  view.depth = DepthImage{96, 64};
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      const double w = inverse_depth(x);
      view.depth(x, y) = w > 0 ? static_cast<float>(1 / w) : 0.0f;
    }
  }
  return view;
}

TEST(FindModelEdges, ACreaseIsFoundBetweenPixels) {
  const double crease = 40.3;
  const auto view = view_of_columns([&](int x) { return 1 - 0.004 * std::abs(x - crease); });
  const auto edges = find_model_edges(view, 8);
  ASSERT_FALSE(edges.empty());
  for (const auto& edge : edges) {
    EXPECT_EQ(edge.axis, 0);
    EXPECT_NEAR(edge.pixel.x(), crease, 0.02);
    EXPECT_NEAR(edge.p_world.z(), 1, 1e-4);
  }
}

TEST(FindModelEdges, AnOutlineLiesOnTheNearSide) {
  for (const double behind : {0.5, 0.0}) {
    const auto view = view_of_columns([&](int x) { return x <= 50 ? 0.8 + 0.001 * x : behind; });
    const auto edges = find_model_edges(view, 8);
    ASSERT_FALSE(edges.empty());
    for (const auto& edge : edges) {
      EXPECT_DOUBLE_EQ(edge.pixel.x(), 50.5);
      EXPECT_NEAR(edge.p_world.z(), 1 / (0.8 + 0.001 * 50.5), 1e-5);
    }
  }
}

TEST(FindModelEdges, PlanesRoughSurfacesAndNothingGiveNone) {
  EXPECT_TRUE(find_model_edges(view_of_columns([](int x) { return 0.5 + 0.005 * x; }), 4).empty());
  EXPECT_TRUE(find_model_edges(view_of_columns([](int) { return 0; }), 4).empty());
  std::mt19937 random{5};
  std::normal_distribution<double> noise{0, 0.002};
  std::vector<double> rough(96);
  for (auto& w : rough) w = 0.8 + noise(random);
  const auto edges = find_model_edges(view_of_columns([&](int x) { return rough[static_cast<std::size_t>(x)]; }), 1);
  EXPECT_LT(edges.size(), 64u * 3u) << "at most three of 86 columns by chance";
}

/// Dark to the left of `at`, bright to the right, with the grey of a camera's pixel in between.
GreyImage step_at(std::initializer_list<double> places) {
  GreyImage image{96, 64, 60};
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      double grey = 60;
      double sign = 1;
      for (const double place : places) {
        grey += sign * 100 / (1 + std::exp(-(x - place) / 0.6));
        sign = -sign;
      }
      image(x, y) = static_cast<std::uint8_t>(std::lround(grey));
    }
  }
  return image;
}

ModelEdge edge_at(double x) {
  return {camera().back_project(x, 30, 1), {x, 30}, 0};
}

TEST(MatchEdges, MeasuresTheStepBetweenPixels) {
  for (const double place : {40.0, 40.25, 40.5, 40.8}) {
    const auto found = match_edges({edge_at(38.4)}, step_at({place}), {}, 0.5);
    ASSERT_EQ(found.size(), 1u) << place;
    EXPECT_NEAR(found[0].pixel.x(), place, 0.08);
    EXPECT_NEAR(std::abs(found[0].normal.x()), 1, 1e-6);
    EXPECT_EQ(found[0].sigma_px, 0.5);
  }
}

TEST(MatchEdges, LeavesOutWhatIsFarFaintAmbiguousOrAtTheBorder) {
  EXPECT_TRUE(match_edges({edge_at(30)}, step_at({40}), {}, 1).empty());
  EXPECT_TRUE(match_edges({edge_at(40)}, GreyImage(96, 64, 80), {}, 1).empty());
  EXPECT_TRUE(match_edges({edge_at(40)}, step_at({37, 43}), {}, 1).empty());
  EXPECT_EQ(match_edges({edge_at(40)}, step_at({40, 45}), {}, 1).size(), 1u);
  EXPECT_TRUE(match_edges({edge_at(2)}, step_at({2}), {}, 1).empty());
  EXPECT_TRUE(match_edges({edge_at(-50)}, step_at({2}), {}, 1).empty());
}

struct Truth {
  Pose T_camera_world = look_at({1.2, -0.4, 0.6}, {0, 0, 0}, Eigen::Vector3d::UnitZ()).inverse();
  std::vector<PointObservation> points;
  std::vector<EdgeObservation> edges;

  explicit Truth(double noise_px) {
    std::mt19937 random{11};
    std::uniform_real_distribution<double> place{-0.3, 0.3};
    std::normal_distribution<double> noise{0, noise_px};
    std::uniform_real_distribution<double> turn{0, 3.14};
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d p_world{place(random), place(random), place(random)};
      const Eigen::Vector2d pixel = camera().project(T_camera_world * p_world);
      const double angle = turn(random);
      const Eigen::Vector2d normal{std::cos(angle), std::sin(angle)};
      const Eigen::Vector2d along{-normal.y(), normal.x()};
      points.push_back({p_world, pixel + Eigen::Vector2d{noise(random), noise(random)}, 1});
      // Anywhere along the edge.
      edges.push_back({p_world, pixel + 5 * place(random) * along + noise(random) * normal, normal, 1});
    }
  }
};

Pose slightly_off(const Pose& pose) {
  Twist off;
  off << 0.01, -0.008, 0.012, 0.006, -0.004, 0.008;
  return exp(off) * pose;
}

TEST(SolvePose, IsExactFromPointsFromEdgesAndFromBoth) {
  const Truth truth{0};
  const Pose start = slightly_off(truth.T_camera_world);
  const auto error = [&](const std::vector<PointObservation>& points, const std::vector<EdgeObservation>& edges) {
    const auto pose = solve_pose(points, edges, camera(), start, {6});
    return pose ? log(pose->T_camera_world * truth.T_camera_world.inverse()).norm() : 1.0;
  };
  EXPECT_LT(error(truth.points, {}), 1e-6);
  EXPECT_LT(error({}, truth.edges), 1e-6);
  EXPECT_LT(error(truth.points, truth.edges), 1e-6);
}

TEST(SolvePose, ToleratesWrongObservations) {
  Truth truth{0.1};
  for (std::size_t i = 0; i < truth.points.size(); i += 4) truth.points[i].pixel.x() += 40;
  for (std::size_t i = 1; i < truth.edges.size(); i += 4) truth.edges[i].pixel += 30 * truth.edges[i].normal;
  const auto pose = solve_pose(truth.points, truth.edges, camera(), slightly_off(truth.T_camera_world), {6});
  ASSERT_TRUE(pose);
  EXPECT_LT(log(pose->T_camera_world * truth.T_camera_world.inverse()).norm(), 0.005);
  EXPECT_EQ(pose->points, 45);
  EXPECT_EQ(pose->edges, 45);
}

TEST(SolvePose, RefusesWhatDoesNotFixThePose) {
  Truth truth{0};
  EXPECT_FALSE(solve_pose({}, {}, camera(), truth.T_camera_world, {}));
  for (auto& edge : truth.edges) edge.normal = Eigen::Vector2d::UnitX();
  for (auto& edge : truth.edges) edge.p_world.z() = 0;
  const std::vector<EdgeObservation> three{truth.edges.begin(), truth.edges.begin() + 3};
  EXPECT_FALSE(solve_pose({}, three, camera(), truth.T_camera_world, {1e6}));
  truth.points.resize(30);
  for (auto& point : truth.points) point.pixel.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solve_pose(truth.points, {}, camera(), truth.T_camera_world, {}));
}

}  // namespace
}  // namespace meshloop
