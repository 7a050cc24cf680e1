#include "device/draw/ar_renderer.h"

#include <GLES3/gl31.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "device/draw/shadow_maps.h"

namespace meshloop {
namespace {

constexpr Rgb8 kBackground{120, 130, 140};
/// The head-up display lies below this row.
constexpr int kHudRows = 32;

Camera camera() {
  return {320, 240, 300, 300, 159.5, 119.5, {}};
}

/// A rectangle in the plane z = `z`, facing -z and +z.
Submesh rectangle(Eigen::Vector2f from, Eigen::Vector2f to, float z) {
  Submesh mesh;
  mesh.positions = {{from.x(), from.y(), z}, {to.x(), from.y(), z}, {to.x(), to.y(), z}, {from.x(), to.y(), z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Submesh box(Eigen::Vector3f centre, float side, Rgb8 color) {
  Submesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner{(i & 1) != 0 ? 0.5f : -0.5f, (i & 2) != 0 ? 0.5f : -0.5f, (i & 4) != 0 ? 0.5f : -0.5f};
    mesh.positions.push_back(centre + side * corner);
    mesh.colors.push_back(color);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Model model_of(Submesh mesh) {
  Model model;
  model.revision = 3;
  model.nodes.push_back(make_node(1, "real", std::move(mesh)));
  return model;
}

std::vector<VirtualObject> one(Submesh mesh) {
  return {{std::make_shared<const Submesh>(std::move(mesh)), Pose::Identity()}};
}

bool same(Rgb8 a, Rgb8 b, int tolerance) {
  return std::abs(a.r - b.r) <= tolerance && std::abs(a.g - b.g) <= tolerance && std::abs(a.b - b.b) <= tolerance;
}

class ArRendererTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto renderer = ArRenderer::create(*context_);
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
  }

  void TearDown() override { EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR)); }

  ColorImage draw(const Model* model, const std::vector<VirtualObject>& objects,
                  const Pose& T_camera_world = Pose::Identity(), bool tracked = true) {
    ArFrame frame;
    frame.camera_image = &background_;
    frame.camera = camera();
    frame.T_camera_world = T_camera_world;
    frame.tracked = tracked;
    frame.model = model;
    frame.objects = &objects;
    frame.hud = {3, tracked ? "tracking" : "lost", 25};
    return renderer_->draw(frame);
  }

  const ColorImage background_{320, 240, kBackground};
  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<ArRenderer> renderer_;
};

/// Pixels whose centre lies in the picture of the rectangle at depth z.
bool covers(double left, double right, double top, double bottom, double z, int x, int y) {
  const double px = (x - 159.5) / 300 * z;
  const double py = (y - 119.5) / 300 * z;
  return px >= left && px <= right && py >= top && py <= bottom;
}

TEST_F(ArRendererTest, HidesTheHalfOfAnObjectThatIsBehindAWall) {
  const Model wall = model_of(rectangle({-2, -2}, {0, 2}, 0.8f));
  const ColorImage picture = draw(&wall, one(box({0.03f, -0.05f, 1.05f}, 0.2f, {230, 30, 30})));
  int agree = 0;
  int all = 0;
  int shown = 0;
  for (int y = 0; y < 240 - kHudRows; ++y) {
    for (int x = 0; x < 320; ++x) {
      // Only the front face can be seen, and a rim of the sides that lies inside its outline.
      const bool in_object = covers(-0.07, 0.13, -0.15, 0.05, 0.95, x, y);
      const bool expected = in_object && (x - 159.5) >= 0;
      const bool visible = !same(picture(x, y), kBackground, 40);
      all += in_object || visible ? 1 : 0;
      agree += (in_object || visible) && expected == visible ? 1 : 0;
      shown += visible ? 1 : 0;
    }
  }
  EXPECT_GT(shown, 1500);
  EXPECT_GE(agree, 0.99 * all) << agree << " of " << all;
}

TEST_F(ArRendererTest, AnObjectBehindAWallIsNotThereAndOneInFrontIs) {
  const Model wall = model_of(rectangle({-2, -2}, {2, 2}, 0.8f));
  const ColorImage behind = draw(&wall, one(box({0, 0, 1.05f}, 0.2f, {230, 30, 30})));
  for (int y = 0; y < 240 - kHudRows; ++y) {
    for (int x = 0; x < 320; ++x) ASSERT_TRUE(same(behind(x, y), kBackground, 1)) << x << ' ' << y;
  }
  const ColorImage in_front = draw(&wall, one(box({0, 0, 0.6f}, 0.2f, {230, 30, 30})));
  EXPECT_GT(in_front(160, 120).r, 2 * in_front(160, 120).g);
}

TEST_F(ArRendererTest, EdgesAreSmooth) {
  const ColorImage picture = draw(nullptr, one(box({0.03f, 0.01f, 1}, 0.2f, {230, 30, 30})),
                                  Pose{Eigen::AngleAxisd{0.2, Eigen::Vector3d::UnitZ()}});
  int between = 0;
  for (const auto pixel : picture.pixels()) between += pixel.g > 60 && pixel.g < 110 ? 1 : 0;
  EXPECT_GT(between, 40);
}

/// Share of the light's disc that a box blocks at a point, by casting rays; only "none" and "all" are used.
bool hits_box(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, const Eigen::AlignedBox3d& target) {
  double nearest = 0;
  double farthest = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (target.min()(axis) - from(axis)) / direction(axis);
    const double b = (target.max()(axis) - from(axis)) / direction(axis);
    nearest = std::max(nearest, std::min(a, b));
    farthest = std::min(farthest, std::max(a, b));
  }
  return nearest <= farthest;
}

TEST_F(ArRendererTest, AnObjectDarkensTheRealFloorWhereItsShadowFallsAndNowhereElse) {
  const Model floor = model_of(rectangle({-1.5f, -1.5f}, {1.5f, 1.5f}, 0));
  const Pose T_camera_world = look_at({0.5, -0.5, 0.9}, {0, 0, 0.05}, Eigen::Vector3d::UnitZ()).inverse();
  const auto objects = one(box({0, 0, 0.16f}, 0.12f, {240, 240, 240}));
  const ColorImage picture = draw(&floor, objects, T_camera_world);
  const Pose T_world_camera = T_camera_world.inverse();
  const Eigen::Vector3d eye = T_world_camera.translation();
  const auto grown = [](double by) {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.06 + by);
    return Eigen::AlignedBox3d{Eigen::Vector3d{0, 0, 0.16} - half, Eigen::Vector3d{0, 0, 0.16} + half};
  };
  // The lamp's disc blurs the outline by 6 % of the distance to what casts it, at most 1.5 cm here.
  constexpr double kBlur_m = 0.018;
  int dark = 0;
  for (int y = 0; y < 240 - kHudRows; ++y) {
    for (int x = 0; x < 320; ++x) {
      const Eigen::Vector3d ray = T_world_camera.linear() * camera().back_project(x, y, 1);
      if (hits_box(eye, ray, grown(0.01))) continue;
      const Eigen::Vector3d on_floor = eye - ray * (eye.z() / ray.z());
      if (hits_box(on_floor, direction_to_light(), grown(-kBlur_m))) {
        ++dark;
        ASSERT_LT(picture(x, y).g, kBackground.g - 25) << x << ' ' << y;
      } else if (!hits_box(on_floor, direction_to_light(), grown(kBlur_m))) {
        ASSERT_TRUE(same(picture(x, y), kBackground, 1)) << x << ' ' << y;
      }
    }
  }
  EXPECT_GT(dark, 100);
}

TEST_F(ArRendererTest, TheModelShadesAnObject) {
  const Model open = model_of(rectangle({-1.5f, -1.5f}, {1.5f, 1.5f}, 0));
  Model roofed = open;
  // A roof towards the light, out of the camera's sight line to the object's top.
  const Eigen::Vector3f above = (direction_to_light() * 0.5).cast<float>();
  Submesh roof = rectangle({-0.3f, -0.3f}, {0.3f, 0.3f}, 0);
  for (auto& p : roof.positions) p += above;
  roofed.nodes.push_back(make_node(2, "roof", std::move(roof)));
  const Pose T_camera_world = look_at({-0.7, -0.2, 0.35}, {0, 0, 0.1}, Eigen::Vector3d::UnitZ()).inverse();
  const auto objects = one(box({0, 0, 0.1f}, 0.12f, {200, 200, 200}));
  const Eigen::Vector2d top = camera().project(T_camera_world * Eigen::Vector3d{0, 0, 0.16});
  const int x = static_cast<int>(top.x());
  const int y = static_cast<int>(top.y());
  const int lit = draw(&open, objects, T_camera_world)(x, y).g;
  const int shaded = draw(&roofed, objects, T_camera_world)(x, y).g;
  EXPECT_LT(shaded, lit - 25);
}

TEST_F(ArRendererTest, LostDrawsThePlainPicture) {
  const Model floor = model_of(rectangle({-1, -1}, {1, 1}, 1));
  const ColorImage picture = draw(&floor, one(box({0, 0, 0.6f}, 0.2f, {230, 30, 30})), Pose::Identity(), false);
  bool hud = false;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (y < 240 - kHudRows) {
        ASSERT_EQ(picture(x, y), kBackground);
      } else {
        hud |= picture(x, y) != kBackground;
      }
    }
  }
  EXPECT_TRUE(hud);
}

TEST_F(ArRendererTest, DrawsTheSameTwice) {
  const Model floor = model_of(rectangle({-1, -1}, {1, 1}, 1));
  const auto objects = one(box({0, 0, 0.8f}, 0.2f, {230, 30, 30}));
  EXPECT_EQ(draw(&floor, objects), draw(&floor, objects));
}

TEST_F(ArRendererTest, WhereTheLastObjectWasLeavesNoTrace) {
  // Only the part of the picture around an object and its shadow is drawn: the parts here meet, end with the picture,
  // reach behind the camera, and lie beside the view.
  const Model floor = model_of(rectangle({-2, -2}, {0.05f, 2}, 1));
  const std::vector<Eigen::Vector3f> centres{{0, 0, 0.8f},        {-0.45f, -0.3f, 0.9f}, {0.3f, 0.2f, 0.7f},
                                             {0.1f, 0.1f, 0.05f}, {3, 0, 0.8f},          {0.02f, 0.02f, 1.05f}};
  for (const auto& centre : centres) {
    const auto objects = one(box(centre, 0.2f, {230, 30, 30}));
    const ColorImage reused = draw(&floor, objects);
    auto fresh = ArRenderer::create(*context_);
    ASSERT_TRUE(fresh);
    std::swap(renderer_, *fresh);
    EXPECT_EQ(draw(&floor, objects), reused) << centre.transpose();
    std::swap(renderer_, *fresh);
  }
}

TEST_F(ArRendererTest, AnObjectLooksTheSameWhateverElseIsDrawn) {
  const Model floor = model_of(rectangle({-2, -2}, {0.05f, 2}, 1));
  auto objects = one(box({0, 0, 0.8f}, 0.2f, {230, 30, 30}));
  const ColorImage alone = draw(&floor, objects);
  // A second one that reaches behind the camera, so that the whole picture is drawn; it hides and shades nothing.
  objects.push_back(one(rectangle({0.01f, 0.01f}, {0.011f, 0.011f}, -0.1f)).front());
  const ColorImage both = draw(&floor, objects);
  int differ = 0;
  for (std::size_t i = 0; i < alone.size(); ++i) differ += same(alone.pixels()[i], both.pixels()[i], 12) ? 0 : 1;
  // The shadow's map is coarser around two.
  EXPECT_LT(differ, 0.002 * static_cast<double>(alone.size()));
}

TEST_F(ArRendererTest, ObjectsThatCannotBeDrawnAreLeftOut) {
  std::vector<VirtualObject> objects = one(box({0, 0, 0.8f}, 0.2f, {230, 30, 30}));
  objects.push_back({});
  objects.push_back({std::make_shared<const Submesh>(), Pose::Identity()});
  objects.push_back(objects.front());
  objects.back().T_world_object.translation().x() = std::nan("");
  EXPECT_EQ(draw(nullptr, objects), draw(nullptr, {objects.front()}));
}

TEST_F(ArRendererTest, APictureOfAnotherSizeOrNoneIsNotAugmented) {
  const auto objects = one(box({0, 0, 0.8f}, 0.2f, {230, 30, 30}));
  const ColorImage small{64, 48, kBackground};
  ArFrame frame;
  frame.camera_image = &small;
  frame.camera = camera();
  frame.tracked = true;
  frame.objects = &objects;
  EXPECT_EQ(renderer_->draw(frame), small);
  frame.camera_image = nullptr;
  const ColorImage black = renderer_->draw(frame);
  EXPECT_EQ(black.width(), 320);
  EXPECT_GT(black(160, 120).r, 100);
}

TEST_F(ArRendererTest, FollowsAChangeOfTheModelAndOfTheSize) {
  const Model wall = model_of(rectangle({-2, -2}, {2, 2}, 0.8f));
  const auto objects = one(box({0, 0, 1.05f}, 0.2f, {230, 30, 30}));
  EXPECT_TRUE(same(draw(&wall, objects)(160, 120), kBackground, 1));
  const Model moved = model_of(rectangle({-2, -2}, {2, 2}, 3));
  EXPECT_FALSE(same(draw(&moved, objects)(160, 120), kBackground, 40));
  const ColorImage large{640, 480, kBackground};
  ArFrame frame;
  frame.camera_image = &large;
  frame.camera = {640, 480, 600, 600, 319.5, 239.5, {}};
  frame.tracked = true;
  frame.model = &moved;
  frame.objects = &objects;
  EXPECT_FALSE(same(renderer_->draw(frame)(320, 240), kBackground, 40));
}

}  // namespace
}  // namespace meshloop
