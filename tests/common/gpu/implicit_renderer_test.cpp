// Shapes on the GPU against the rays that common/implicit casts in double.
#include <GLES3/gl31.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "common/gpu/scene_renderer.h"
#include "common/implicit/cast_ray.h"
#include "common/implicit/shape_file.h"

namespace meshloop {
namespace {

using Eigen::Vector3d;

constexpr double kAccuracy_m = 1e-4;

Camera camera_of(int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.9 * width;
  camera.cx = 0.5 * width - 0.7;
  camera.cy = 0.5 * height + 0.3;
  return camera;
}

/// Looks from `eye` towards `target`, y down.
Pose look_at(const Vector3d& eye, const Vector3d& target) {
  const Vector3d z = (target - eye).normalized();
  const Vector3d x = z.cross(Vector3d{0.1, 0.2, 1}).normalized();
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear() << x, z.cross(x), z;
  T_world_camera.translation() = eye;
  return T_world_camera.inverse();
}

Shape solid(const std::string& text) {
  const auto shapes = parse_shapes("shapes:\n  - name: a\n    color: [255, 0, 51]\n    solid: " + text + "\n");
  EXPECT_TRUE(shapes) << shapes.error().message;
  return shapes ? shapes->front().shape : Shape{};
}

Node shape_node(NodeId id, const std::string& text, const Pose& T_world_node) {
  Submesh stand_in;
  stand_in.positions = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}};
  stand_in.triangles = {{0, 1, 2}};
  // Large and elsewhere: a pixel of it would be noticed.
  Node node = make_node(id, "shape", stand_in, T_world_node);
  node.shape = std::make_shared<const Shape>(solid(text));
  return node;
}

struct Expected {
  double depth = 0;
  std::uint32_t node = 0;
};

class ImplicitRendererTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto renderer = SceneRenderer::create(*context_);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
  }
  void TearDown() override {
    if (context_ != nullptr) {
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    }
  }

  /// The nearest of all shapes along a pixel's ray.
  static Expected expected_at(const Model& model, const SceneView& view, double u, double v) {
    const Camera& camera = view.camera;
    const Vector3d direction{(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1};
    Expected expected;
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      const Pose T_node_camera = (view.T_camera_world * model.nodes[i].T_world_node).inverse();
      const Ray ray{T_node_camera.translation(), T_node_camera.linear() * direction};
      const auto hit = cast_ray(*model.nodes[i].shape, ray, static_cast<double>(view.near_m),
                                expected.node == 0 ? static_cast<double>(view.far_m) : expected.depth);
      if (hit) expected = {hit->t, static_cast<std::uint32_t>(i + 1)};
    }
    return expected;
  }

  /// True when rays a hundredth of a pixel beside this one agree with what was drawn, or disagree with each other by
  /// more: an outline, or a surface seen from its side.
  static bool is_at_an_edge(const Model& model, const SceneView& view, int u, int v, const Expected& drawn) {
    constexpr double kBeside = 0.01;
    double low = 1e9, high = -1e9;
    bool same_node = true;
    for (const auto& [du, dv] : {std::pair{-1, -1}, {1, -1}, {-1, 1}, {1, 1}, {0, 0}}) {
      const auto near = expected_at(model, view, u + kBeside * du, v + kBeside * dv);
      low = std::min(low, near.depth);
      high = std::max(high, near.depth);
      same_node &= near.node == drawn.node;
    }
    return !same_node ||
           (drawn.depth > low - kAccuracy_m && drawn.depth < high + kAccuracy_m && high - low > kAccuracy_m);
  }

  void expect_exact(const Model& model, const SceneView& view) {
    renderer_->render(model, view);
    const DepthImage depth = renderer_->read_depth();
    const auto nodes = renderer_->read_nodes();
    int hits = 0, edges = 0, wrong = 0;
    double worst = 0;
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u) {
        const Expected expected = expected_at(model, view, u, v);
        const Expected drawn{static_cast<double>(depth(u, v)), nodes(u, v)};
        const double error = std::abs(drawn.depth - expected.depth);
        hits += expected.node != 0 ? 1 : 0;
        if (drawn.node == expected.node && error <= kAccuracy_m) {
          worst = std::max(worst, error);
        } else if (is_at_an_edge(model, view, u, v, drawn)) {
          ++edges;
        } else if (++wrong < 4) {
          ADD_FAILURE() << "pixel " << u << ", " << v << ": " << drawn.depth << " m of node " << drawn.node
                        << " in place of " << expected.depth << " m of node " << expected.node;
        }
      }
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(hits, depth.width() * depth.height() / 50);
    EXPECT_LT(edges, hits / 200 + 2) << "of " << hits;
    RecordProperty("worst_um", static_cast<int>(1e6 * worst));
    std::printf("worst %.1f um of %d pixels, %d at edges\n", 1e6 * worst, hits, edges);
  }

  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<SceneRenderer> renderer_;
};

const char* const kSolids[] = {"{sphere: {radius: 0.5}}",
                               "{box: {size: [0.6, 0.8, 1.0]}}",
                               "{cylinder: {radius: 0.4, height: 0.9}}",
                               "{cone: {radius: 0.5, height: 0.9}}",
                               "{torus: {radius: 0.5, tube: 0.2}}",
                               "{intersection: [{sphere: {radius: 0.6}}, {transform: {translation: [0, 0, 0.1], axis: "
                               "[1, 1, 0], angle_deg: 25, of: {plane: }}}]}",
                               "{difference: [{box: {size: [1, 1, 0.6]}}, {sphere: {radius: 0.4}}, {transform: {axis: "
                               "[1, 0, 0], angle_deg: 90, of: "
                               "{cylinder: {radius: 0.2, height: 3}}}}]}",
                               "{union: [{torus: {radius: 0.4, tube: 0.1}}, {transform: {translation: [0.3, 0, -0.2], "
                               "of: {cone: {radius: 0.2, height: 0.6}}}}]}"};

TEST_F(ImplicitRendererTest, DepthIsThatOfTheRaysFromSeveralViews) {
  SceneView view;
  view.camera = camera_of(160, 120);
  for (const char* text : kSolids) {
    SCOPED_TRACE(text);
    Model model;
    model.nodes.push_back(shape_node(
        1, text,
        make_pose({0.2, -0.1, 0.3}, Eigen::Quaterniond{Eigen::AngleAxisd{0.4, Vector3d{1, 2, 3}.normalized()}})));
    for (const Vector3d& eye : {Vector3d{0.3, -2.9, 0.9}, Vector3d{1.2, 0.8, -0.7}, Vector3d{-0.1, 0.2, 3.2}}) {
      view.T_camera_world = look_at(eye, {0.2, -0.1, 0.3});
      expect_exact(model, view);
    }
  }
}

TEST_F(ImplicitRendererTest, ASphereIsSeenFromItsCentre) {
  Model model;
  model.nodes.push_back(shape_node(1, "{sphere: {radius: 1}}", Pose::Identity()));
  SceneView view;
  view.camera = camera_of(160, 120);
  for (const Vector3d& eye : {Vector3d{0, 0, 0}, Vector3d{0.6, -0.3, 0.5}}) {
    view.T_camera_world = look_at(eye, {0, 5, 0});
    expect_exact(model, view);
  }
  // From its very centre every ray is 1 m long: depth is the cosine.
  view.T_camera_world = look_at(Vector3d::Zero(), {0, 1, 0});
  renderer_->render(model, view);
  const DepthImage depth = renderer_->read_depth();
  for (int v = 0; v < depth.height(); v += 7) {
    for (int u = 0; u < depth.width(); u += 7) {
      const double x = (u - view.camera.cx) / view.camera.fx, y = (v - view.camera.cy) / view.camera.fy;
      EXPECT_NEAR(depth(u, v), 1 / std::sqrt(1 + x * x + y * y), 1e-6);
    }
  }
}

TEST_F(ImplicitRendererTest, ShapesAndTrianglesHideEachOther) {
  Model model;
  model.nodes.push_back(shape_node(1, "{sphere: {radius: 0.3}}", make_pose({0, 0, 2}, Eigen::Quaterniond::Identity())));
  Submesh square;
  square.positions = {{-1, -1, 1.8f}, {0, -1, 1.8f}, {0, 1, 1.8f}, {-1, 1, 1.8f}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  model.nodes.push_back(make_node(2, "square", square));
  SceneView view;
  view.camera = camera_of(161, 121);
  view.camera.cx = 80;
  view.camera.cy = 60;
  renderer_->render(model, view);
  const auto nodes = renderer_->read_nodes();
  const auto depth = renderer_->read_depth();
  EXPECT_EQ(nodes(83, 60), 1u);
  EXPECT_EQ(nodes(77, 60), 1u);  // the sphere begins at 1.7 m
  EXPECT_EQ(nodes(60, 60), 2u);  // where it bends behind 1.8 m
  EXPECT_EQ(nodes(98, 60), 1u);
  EXPECT_FLOAT_EQ(depth(40, 60), 1.8f);
  EXPECT_EQ(nodes(120, 60), 0u);
  GreyImage mask;
  const auto color = renderer_->read_color(&mask);
  EXPECT_EQ(color(83, 60), (Rgb8{255, 0, 51}));
  EXPECT_EQ(mask(83, 60), 255);
  EXPECT_EQ(mask(40, 60), 0);
}

TEST_F(ImplicitRendererTest, DrawsTheSameIntoAnArea) {
  Model model;
  model.nodes.push_back(
      shape_node(1, "{torus: {radius: 0.4, tube: 0.15}}", make_pose({0, 0, 2}, Eigen::Quaterniond::Identity())));
  SceneView view;
  view.camera = camera_of(160, 120);
  renderer_->render(model, view);
  const auto whole = renderer_->read_depth();
  view.area = ScreenArea{40, 30, 50, 40};
  view.nodes = view.color = false;
  renderer_->render(model, view);
  const auto part = renderer_->read_depth();
  for (int v = 30; v < 70; ++v) {
    for (int u = 40; u < 90; ++u) EXPECT_EQ(part(u, v), whole(u, v)) << u << ", " << v;
  }
}

}  // namespace
}  // namespace meshloop
