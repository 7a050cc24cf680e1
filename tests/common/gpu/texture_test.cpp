// Textured nodes as SceneRenderer draws them, against common/mesh/texture.h.
#include <GLES3/gl31.h>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "common/gpu/scene_renderer.h"
#include "textured_wall.h"

namespace meshloop {
namespace {

using test::textured_wall;

/// Bilinear weights have eight bits on some hardware, and on Mesa's software renderer; a level is lost in rounding.
constexpr int kLevels = 3;

class TextureRendering : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto renderer = SceneRenderer::create(*context_);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
    view_.camera = {200, 150, 180, 170, 99.25, 74.5, {}};
  }
  void TearDown() override {
    if (context_ != nullptr) {
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    }
  }

  /// How many pixels show the wall; each as the texture says for the point that it shows.
  int expect_wall(const Submesh& wall, const Pose& T_world_wall, const Eigen::Vector3d& eye) {
    Model model;
    model.nodes.push_back(make_node(1, "wall", wall, T_world_wall));
    view_.T_camera_world = look_at(eye, T_world_wall * Eigen::Vector3d{0.1, 0, 1.5}, {0, -1, 0}).inverse();
    renderer_->render(model, view_);
    GreyImage mask;
    const auto color = renderer_->read_color(&mask);
    const auto depth = renderer_->read_depth();
    const auto picture = decode_jpeg(wall.texture->jpeg).value();
    const Pose T_node_camera = (view_.T_camera_world * T_world_wall).inverse();
    int seen = 0;
    int worst = 0;
    for (int v = 0; v < color.height(); ++v) {
      for (int u = 0; u < color.width(); ++u) {
        if (depth(u, v) == 0) continue;
        EXPECT_EQ(mask(u, v), 255);
        ++seen;
        // The ray's own point in the wall's plane: depth is not what is tested.
        const Eigen::Vector3d ray = T_node_camera.linear() * view_.camera.back_project(u, v, 1);
        const Eigen::Vector3d p =
            T_node_camera.translation() + ray * ((1.5 - T_node_camera.translation().z()) / ray.z());
        const Rgb8 expected = bilinear(picture, pixel_of(*wall.texture, p.cast<float>()));
        const Rgb8 drawn = color(u, v);
        worst = std::max(
            {worst, std::abs(drawn.r - expected.r), std::abs(drawn.g - expected.g), std::abs(drawn.b - expected.b)});
      }
    }
    EXPECT_LE(worst, kLevels);
    return seen;
  }

  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<SceneRenderer> renderer_;
  SceneView view_;
};

TEST_F(TextureRendering, IsExactFromTheFront) {
  EXPECT_GT(expect_wall(textured_wall(), Pose::Identity(), {0, 0, 0}), 15'000);
}

TEST_F(TextureRendering, IsExactFromAsideAcrossLargeTriangles) {
  // 70 degrees aside, on the projector's other side: evenly interpolated coordinates would be many pixels off.
  EXPECT_GT(expect_wall(textured_wall(), Pose::Identity(), {2.2, 0.2, 0.75}), 2'000);
  EXPECT_GT(expect_wall(textured_wall(), Pose::Identity(), {-1.2, -0.8, 0.9}), 2'000);
}

TEST_F(TextureRendering, MovesWithItsNode) {
  const Pose T_world_node = make_pose(
      {0.4, -0.2, 0.7}, Eigen::Quaterniond{Eigen::AngleAxisd{0.6, Eigen::Vector3d{0.2, 1, -0.3}.normalized()}});
  EXPECT_GT(expect_wall(textured_wall(), T_world_node, {0.3, 0, -0.2}), 8'000);
}

TEST_F(TextureRendering, StaysWhereItIsWhenTrianglesGo) {
  EXPECT_GT(expect_wall(keep_triangles(textured_wall(), {false, true}), Pose::Identity(), {0, 0, 0}), 7'000);
}

TEST_F(TextureRendering, NodesBesideKeepTheirOwnColors) {
  Submesh colored = textured_wall();
  colored.texture = nullptr;
  colored.colors.assign(4, {10, 200, 30});
  Submesh plain = colored;
  plain.colors.clear();
  const auto at = [](double x) { return make_pose({x, 0, 3}, Eigen::Quaterniond::Identity()); };
  Model model;
  model.nodes.push_back(make_node(1, "colored", colored, at(-1.6)));
  model.nodes.push_back(make_node(2, "textured", textured_wall(), at(0)));
  model.nodes.push_back(make_node(3, "plain", plain, at(1.6)));
  renderer_->render(model, view_);
  GreyImage mask;
  const auto color = renderer_->read_color(&mask);
  const auto nodes = renderer_->read_nodes();
  EXPECT_EQ(nodes(35, 74), 1u);
  EXPECT_EQ(color(35, 74), (Rgb8{10, 200, 30}));
  EXPECT_EQ(nodes(99, 74), 2u);
  EXPECT_EQ(mask(99, 74), 255);
  EXPECT_EQ(nodes(165, 74), 3u);
  EXPECT_EQ(color(165, 74), (Rgb8{128, 128, 128}));
  EXPECT_EQ(mask(165, 74), 0);
}

TEST_F(TextureRendering, APictureThatCannotBeDecodedLeavesTheNodeGrey) {
  Submesh wall = textured_wall();
  auto damaged = std::make_shared<ProjectedTexture>(*wall.texture);
  damaged->jpeg.resize(damaged->jpeg.size() / 2);
  wall.texture = std::move(damaged);
  Model model;
  model.nodes.push_back(make_node(1, "wall", wall));
  renderer_->render(model, view_);
  GreyImage mask;
  EXPECT_EQ(renderer_->read_color(&mask)(100, 75), (Rgb8{128, 128, 128}));
  EXPECT_EQ(mask(100, 75), 0);
}

}  // namespace
}  // namespace meshloop
