#include "common/gpu/scene_renderer.h"

#include <GLES3/gl31.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace meshloop {
namespace {

constexpr Rgb8 kRed{255, 0, 0};

Camera small_camera() {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = 60;
  camera.fy = 55;
  camera.cx = 30.25;
  camera.cy = 24.5;
  return camera;
}

// Two triangles; corners in order around the border.
Submesh quad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c, const Eigen::Vector3f& d) {
  Submesh submesh;
  submesh.positions = {a, b, c, d};
  submesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return submesh;
}

Submesh facing_square(float half, float z) {
  return quad({-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z});
}

Model model_of(std::vector<Submesh> submeshes) {
  Model model;
  NodeId id = 1;
  for (auto& submesh : submeshes) {
    model.nodes.push_back(make_node(id, "node", std::move(submesh)));
    ++id;
  }
  return model;
}

class SceneRendererTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto renderer = SceneRenderer::create(*context_);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
    view_.camera = small_camera();
  }
  void TearDown() override {
    if (context_ != nullptr) {
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    }
  }
  void render(const Model& model) { renderer_->render(model, view_); }

  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<SceneRenderer> renderer_;
  SceneView view_;
};

TEST_F(SceneRendererTest, EmptyModelLeavesNothing) {
  render(Model{});
  const auto depth_image = renderer_->read_depth();
  for (const float z : depth_image.pixels()) EXPECT_EQ(z, 0.0F);
  const auto nodes_image = renderer_->read_nodes();
  for (const auto node : nodes_image.pixels()) EXPECT_EQ(node, 0U);
}

TEST_F(SceneRendererTest, CoversThePixelsWhoseCentreProjectsInside) {
  render(model_of({facing_square(0.3F, 1.5F)}));
  const auto depth = renderer_->read_depth();
  const Camera camera = view_.camera;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d p = camera.back_project(u, v, 1.5);
      const double outside = p.head<2>().cwiseAbs().maxCoeff() - 0.3;
      if (std::abs(outside) < 1e-4) continue;
      EXPECT_NEAR(depth(u, v), outside < 0 ? 1.5 : 0.0, 2e-6) << u << ", " << v;
    }
  }
}

TEST_F(SceneRendererTest, RowZeroIsTheTop) {
  // Above the optical axis: y points down in the camera's frame.
  render(model_of({quad({-1, -1, 1}, {1, -1, 1}, {1, -0.2F, 1}, {-1, -0.2F, 1})}));
  const auto depth = renderer_->read_depth();
  EXPECT_GT(depth(30, 0), 0.0F);
  EXPECT_EQ(depth(30, 47), 0.0F);
}

TEST_F(SceneRendererTest, DepthOfASlantedPlaneIsExactAlongTheAxis) {
  // z = 2 + 0.8 x - 0.5 y: steep, so that interpolation without perspective would be centimetres off.
  const auto at = [](float x, float y) { return Eigen::Vector3f(x, y, 2 + 0.8F * x - 0.5F * y); };
  render(model_of({quad(at(-3, -3), at(3, -3), at(3, 3), at(-3, 3))}));
  const auto depth = renderer_->read_depth();
  const Camera camera = view_.camera;
  int seen = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = camera.back_project(u, v, 1);
      const double z = 2 / (1 - 0.8 * ray.x() + 0.5 * ray.y());
      if (z < 0.5 || z > 3) continue;
      EXPECT_NEAR(depth(u, v), z, 1e-5) << u << ", " << v;
      ++seen;
    }
  }
  EXPECT_GT(seen, 2000);
}

TEST_F(SceneRendererTest, OneMillimetreAtThreeMetresDecides) {
  // The nearer one is drawn first, then last: order must not matter.
  for (const bool nearer_first : {true, false}) {
    auto nearer = facing_square(2, 2.999F);
    auto farther = facing_square(2, 3);
    if (nearer_first) {
      render(model_of({nearer, farther}));
    } else {
      render(model_of({farther, nearer}));
    }
    const std::uint32_t expected = nearer_first ? 1 : 2;
    const auto nodes_image = renderer_->read_nodes();
    for (const auto node : nodes_image.pixels()) ASSERT_EQ(node, expected);
  }
}

TEST_F(SceneRendererTest, PoseFarFromTheOriginMovesNothing) {
  Model model = model_of({facing_square(0.3F, 1.5F)});
  render(model);
  const auto near_origin = renderer_->read_depth();
  Pose T_far = Pose::Identity();
  T_far.translation() = Eigen::Vector3d(8000, -3000, 900);
  T_far.linear() = Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  model.nodes[0].T_world_node = T_far;
  view_.T_camera_world = T_far.inverse();
  render(model);
  const auto far_away = renderer_->read_depth();
  for (std::size_t i = 0; i < near_origin.size(); ++i) {
    ASSERT_NEAR(near_origin.pixels()[i], far_away.pixels()[i], 2e-6);
  }
}

TEST_F(SceneRendererTest, NodeIndexCountsFromOneInTheModelsOrder) {
  auto model = model_of({facing_square(0.1F, 1), facing_square(0.1F, 1)});
  model.nodes[0].T_world_node.translation() = Eigen::Vector3d(-0.2, 0, 0);
  model.nodes[1].T_world_node.translation() = Eigen::Vector3d(0.2, 0, 0);
  render(model);
  const auto nodes = renderer_->read_nodes();
  EXPECT_EQ(nodes(18, 24), 1U);
  EXPECT_EQ(nodes(30, 24), 0U);
  EXPECT_EQ(nodes(42, 24), 2U);
}

TEST_F(SceneRendererTest, ColorIsTheVerticesOwnAndMaskSaysWhereThereIsOne) {
  auto colored = facing_square(0.1F, 1);
  colored.colors.assign(4, kRed);
  auto model = model_of({colored, facing_square(0.1F, 1)});
  model.nodes[0].T_world_node.translation() = Eigen::Vector3d(-0.2, 0, 0);
  model.nodes[1].T_world_node.translation() = Eigen::Vector3d(0.2, 0, 0);
  render(model);
  GreyImage mask;
  const auto color = renderer_->read_color(&mask);
  EXPECT_EQ(color(18, 24), kRed);
  EXPECT_EQ(mask(18, 24), 255);
  EXPECT_EQ(mask(30, 24), 0);
  EXPECT_NEAR(color(42, 24).g, 128, 1);
  EXPECT_EQ(mask(42, 24), 0);
}

TEST_F(SceneRendererTest, BothSidesAreDrawn) {
  auto square = facing_square(1, 1);
  for (auto& triangle : square.triangles) std::swap(triangle[1], triangle[2]);
  render(model_of({square}));
  EXPECT_FLOAT_EQ(renderer_->read_depth()(30, 24), 1.0F);
}

TEST_F(SceneRendererTest, SurfaceThroughTheCameraIsCutAtTheNearPlane) {
  // The floor below the camera reaches behind it.
  render(model_of({quad({-5, 0.5F, -5}, {5, 0.5F, -5}, {5, 0.5F, 20}, {-5, 0.5F, 20})}));
  const auto depth = renderer_->read_depth();
  const double z = 0.5 * view_.camera.fy / (47 - view_.camera.cy);
  EXPECT_NEAR(depth(30, 47), z, 1e-5);
  EXPECT_EQ(depth(30, 0), 0.0F);
}

TEST_F(SceneRendererTest, TargetsFollowTheCamerasSize) {
  const auto model = model_of({facing_square(3, 1)});
  render(model);
  view_.camera.width = 200;
  view_.camera.height = 17;
  render(model);
  const auto depth = renderer_->read_depth();
  EXPECT_EQ(depth.width(), 200);
  EXPECT_EQ(depth.height(), 17);
  EXPECT_FLOAT_EQ(depth(199, 0), 1.0F);
}

TEST_F(SceneRendererTest, StateLeftByOthersDoesNotMatter) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(0, 0, 1, 1);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT_AND_BACK);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDepthMask(GL_FALSE);
  glDepthFunc(GL_NEVER);
  render(model_of({facing_square(3, 1)}));
  const auto depth_image = renderer_->read_depth();
  for (const float z : depth_image.pixels()) ASSERT_FLOAT_EQ(z, 1.0F);
}

TEST_F(SceneRendererTest, TwoRenderersInTwoContextsDoNotMeet) {
  auto other_context = GpuContext::create_headless();
  ASSERT_TRUE(other_context);
  auto other = SceneRenderer::create(**other_context);
  ASSERT_TRUE(other);
  render(model_of({facing_square(3, 1)}));
  (*other)->render(model_of({facing_square(3, 2)}), view_);
  EXPECT_FLOAT_EQ(renderer_->read_depth()(3, 3), 1.0F);
  EXPECT_FLOAT_EQ((*other)->read_depth()(3, 3), 2.0F);
  other->reset();
  EXPECT_FLOAT_EQ(renderer_->read_depth()(3, 3), 1.0F);
}

TEST_F(SceneRendererTest, NodesOutsideTheViewLeaveTheOthersAlone) {
  auto model = model_of({facing_square(0.1F, -1), facing_square(0.1F, 80), facing_square(0.1F, 1)});
  model.nodes.push_back(model.nodes[2]);
  model.nodes[3].T_world_node.translation() = Eigen::Vector3d(50, 0, 0);
  render(model);
  EXPECT_EQ(renderer_->read_nodes()(30, 24), 3U);
}

TEST_F(SceneRendererTest, APartAloneIsDrawnAsInTheWholePicture) {
  // Two squares, so that one of them lies beside the part and is left out.
  auto model = model_of({facing_square(0.2F, 1), facing_square(0.2F, 2)});
  model.nodes[1].T_world_node.translation() = Eigen::Vector3d(0.5, 0, 0);
  render(model);
  const auto depth = renderer_->read_depth();
  const auto nodes = renderer_->read_nodes();
  view_.area = ScreenArea{20, 10, 17, 30};
  view_.nodes = view_.color = false;
  renderer_->render(model, view_);
  const auto part = renderer_->read_depth();
  for (int v = 10; v < 40; ++v) {
    for (int u = 20; u < 37; ++u) ASSERT_EQ(part(u, v), depth(u, v)) << u << ", " << v;
  }
  EXPECT_EQ(renderer_->read_nodes(), nodes) << "nodes that are not wanted are left alone";
  view_.area.reset();
  view_.nodes = view_.color = true;
  renderer_->render(model, view_);
  EXPECT_EQ(renderer_->read_depth(), depth);
}

/// A closed tube of 3 cm along a trefoil knot of 0.3 m, which hides parts of itself from everywhere.
Submesh knot() {
  constexpr int kAlong = 400;
  constexpr int kAround = 24;
  const auto middle = [](double t) -> Eigen::Vector3d {
    return Eigen::Vector3d{std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t), -std::sin(3 * t)} / 10;
  };
  Submesh submesh;
  for (int i = 0; i < kAlong; ++i) {
    const double t = 2 * std::numbers::pi * i / kAlong;
    const Eigen::Vector3d along = (middle(t + 1e-4) - middle(t - 1e-4)).normalized();
    const Eigen::Vector3d side = along.cross(Eigen::Vector3d::UnitZ()).normalized();
    const Eigen::Vector3d up = side.cross(along);
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2 * std::numbers::pi * k / kAround;
      submesh.positions.emplace_back(
          (middle(t) + 0.03 * (std::cos(angle) * side + std::sin(angle) * up)).cast<float>());
    }
  }
  const auto vertex = [](int i, int k) { return static_cast<std::uint32_t>(i % kAlong * kAround + k % kAround); };
  for (int i = 0; i < kAlong; ++i) {
    for (int k = 0; k < kAround; ++k) {
      submesh.triangles.push_back({vertex(i, k), vertex(i, k + 1), vertex(i + 1, k)});
      submesh.triangles.push_back({vertex(i + 1, k), vertex(i, k + 1), vertex(i + 1, k + 1)});
    }
  }
  return submesh;
}

TEST_F(SceneRendererTest, LeavingOutWhatFacesAwayChangesNoPixel) {
  // With a tolerance that only the finest level keeps to, nothing differs from every triangle but what faces away.
  const Tolerance finest{[](double) { return 1e-9; }};
  Submesh inside_out = knot();
  for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
  for (auto& p : inside_out.positions) p.x() += 0.4F;
  const auto model = model_of({knot(), inside_out});
  context_->meshes().finish(model);
  view_.camera.width = 320;
  view_.camera.height = 240;
  view_.camera.fx = view_.camera.fy = 300;
  view_.camera.cx = 159.5;
  view_.camera.cy = 119.5;
  for (int i = 0; i < 24; ++i) {
    const Eigen::AngleAxisd turn{0.7 * i, Eigen::Vector3d{std::sin(3.0 * i), std::cos(2.0 * i), 0.5}.normalized()};
    // From 0.9 m away down to places amid the knot.
    view_.T_camera_world = (turn * Eigen::Translation3d{0, 0, -0.9 + 0.035 * i}).inverse();
    view_.tolerance = Tolerance{};
    render(model);
    const auto depth = renderer_->read_depth();
    const auto nodes = renderer_->read_nodes();
    view_.tolerance = finest;
    render(model);
    EXPECT_EQ(renderer_->read_depth(), depth) << i;
    EXPECT_EQ(renderer_->read_nodes(), nodes) << i;
  }
}

TEST(MeshCache, MakesLevelsOfDetailOnlyForWhoDrawsThem) {
  auto context = GpuContext::create_headless();
  ASSERT_TRUE(context);
  MeshCache cache;
  constexpr int kCells = 60;
  Submesh flat;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j)
      flat.positions.emplace_back(0.01f * static_cast<float>(j), 0.01f * static_cast<float>(i), 1.0f);
  }
  for (std::uint32_t i = 0; i < kCells; ++i) {
    for (std::uint32_t j = 0; j < kCells; ++j) {
      const std::uint32_t here = i * (kCells + 1) + j, above = here + kCells + 1;
      flat.triangles.push_back({here, here + 1, above});
      flat.triangles.push_back({here + 1, above + 1, above});
    }
  }
  flat.colors.assign(flat.positions.size(), Rgb8{200, 10, 10});
  Model model = model_of({flat});
  cache.update(model, false);
  EXPECT_EQ(cache.mesh_of(model.nodes[0]).hierarchy, nullptr);
  cache.finish(model);
  const auto* hierarchy = cache.mesh_of(model.nodes[0]).hierarchy;
  ASSERT_NE(hierarchy, nullptr);
  EXPECT_GT(hierarchy->groups.size(), 1U);
  // What is being built for a model that is gone must not keep it.
  model = model_of({flat});
  cache.update(model, true);
  model = {};
  cache.finish(model);
  cache.update(model, false);
  EXPECT_EQ(cache.size(), 0U);
}

TEST(MeshCache, UploadsASharedSubmeshOnceAndFreesWhatNobodyHolds) {
  auto context = GpuContext::create_headless();
  ASSERT_TRUE(context);
  MeshCache cache;
  Model model = model_of({facing_square(1, 1), facing_square(1, 2)});
  model.nodes.push_back(model.nodes[0]);
  cache.update(model, false);
  EXPECT_EQ(cache.size(), 2U);
  EXPECT_EQ(cache.mesh_of(model.nodes[0]).index_count, 6);
  const unsigned kept = cache.mesh_of(model.nodes[1]).vertex_array;
  const unsigned freed = cache.mesh_of(model.nodes[0]).vertex_array;
  Model next;
  next.nodes.push_back(model.nodes[1]);
  cache.update(next, false);
  EXPECT_EQ(cache.size(), 2U) << "the first model may still be drawn";
  model = {};
  cache.update(next, false);
  EXPECT_EQ(cache.size(), 1U);
  EXPECT_EQ(cache.mesh_of(next.nodes[0]).vertex_array, kept);
  EXPECT_FALSE(glIsVertexArray(freed));
  EXPECT_EQ(cache.mesh_of(Node{}).index_count, 0);
}

}  // namespace
}  // namespace meshloop
