#include "common/gpu/implicit_renderer.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "common/gpu/projection.h"
#include "common/gpu/scene_renderer.h"
#include "common/gpu/screen_area.h"
#include "shaders/shaders.h"

namespace meshloop {
namespace {

// The uniforms' locations in implicit.frag.
constexpr GLint kPrimitiveCount = 0;
constexpr GLint kStepCount = 1;
constexpr GLint kIntrinsics = 2;
constexpr GLint kNearFar = 3;
constexpr GLint kNodeIndex = 4;
constexpr GLint kColor = 5;
constexpr GLuint kShapeBinding = 0;

/// The shader's uniform block, std140.
struct ShapeBlock {
  struct Entry {
    std::array<float, 16> from_camera;
    std::array<float, 4> size_and_kind;
  };
  std::array<Entry, kMaxPrimitives> primitives{};
  std::array<std::int32_t, kMaxSteps> steps{};
};
static_assert(sizeof(ShapeBlock) == kMaxPrimitives * 80 + kMaxSteps * 4);

ShapeBlock block_of(const Shape& shape, const Pose& T_node_camera) {
  ShapeBlock block;
  for (std::size_t i = 0; i < shape.primitives.size(); ++i) {
    const Primitive& primitive = shape.primitives[i];
    // In double up to here: far from the origin a float product would move what the camera sees.
    const Eigen::Matrix4f from_camera = (primitive.T_primitive_node * T_node_camera).matrix().cast<float>();
    std::copy_n(from_camera.data(), 16, block.primitives[i].from_camera.begin());
    const Eigen::Vector3f size = primitive.size.cast<float>();
    block.primitives[i].size_and_kind = {size.x(), size.y(), size.z(), static_cast<float>(primitive.kind)};
  }
  std::transform(shape.steps.begin(), shape.steps.end(), block.steps.begin(),
                 [](const ShapeStep& step) { return static_cast<std::int32_t>(step.value); });
  return block;
}

ScreenArea area_of(const Shape& shape, const Pose& T_world_node, const SceneView& view) {
  std::vector<Eigen::Vector3d> corners;
  const Eigen::AlignedBox3f bounds = bounds_of(shape).cast<float>();
  const Eigen::Matrix4d clip_from_node =
      clip_from_camera(view.camera, view.near_m, view.far_m) * (view.T_camera_world * T_world_node).matrix();
  if (is_outside_view(clip_from_node, bounds)) return {};
  append_corners(corners, bounds, T_world_node);
  ScreenArea area = area_of_hull(corners, view.camera, view.T_camera_world, static_cast<double>(view.near_m));
  if (!view.area) return area;
  const int right = std::min(area.x + area.width, view.area->x + view.area->width);
  const int bottom = std::min(area.y + area.height, view.area->y + view.area->height);
  area.x = std::max(area.x, view.area->x);
  area.y = std::max(area.y, view.area->y);
  area.width = right - area.x;
  area.height = bottom - area.y;
  return area;
}

}  // namespace

Result<ImplicitRenderer> ImplicitRenderer::create() {
  auto program = Program::create(shaders::implicit_vert, shaders::implicit_frag);
  if (!program) return fail("preparing shapes", program.error());
  return ImplicitRenderer{std::move(*program)};
}

void ImplicitRenderer::draw(const Model& model, const SceneView& view) const {
  const auto has_shape = [](const Node& node) { return node.shape != nullptr; };
  if (std::none_of(model.nodes.begin(), model.nodes.end(), has_shape)) return;
  program_.use();
  glBindVertexArray(no_vertices_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, kShapeBinding, block_.name());
  glEnable(GL_SCISSOR_TEST);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const Node& node = model.nodes[i];
    if (node.shape) draw_shape(*node.shape, node.T_world_node, static_cast<unsigned>(i + 1), view);
  }
  glDisable(GL_SCISSOR_TEST);
  glBindBufferBase(GL_UNIFORM_BUFFER, kShapeBinding, 0);
  glBindVertexArray(0);
}

void ImplicitRenderer::draw_shape(const Shape& shape, const Pose& T_world_node, unsigned node_index,
                                  const SceneView& view) const {
  const ScreenArea area = area_of(shape, T_world_node, view);
  if (area.empty() || !validate(shape)) return;
  glScissor(area.x, area.y, area.width, area.height);
  const ShapeBlock block = block_of(shape, (view.T_camera_world * T_world_node).inverse());
  glBufferData(GL_UNIFORM_BUFFER, sizeof block, &block, GL_STREAM_DRAW);
  glUniform1i(kPrimitiveCount, static_cast<GLint>(shape.primitives.size()));
  glUniform1i(kStepCount, static_cast<GLint>(shape.steps.size()));
  const Camera& camera = view.camera;
  glUniform4f(kIntrinsics, static_cast<float>(camera.fx), static_cast<float>(camera.fy), static_cast<float>(camera.cx),
              static_cast<float>(camera.cy));
  glUniform2f(kNearFar, view.near_m, view.far_m);
  glUniform1ui(kNodeIndex, node_index);
  const auto channel = [](std::uint8_t byte) { return static_cast<float>(byte) / 255; };
  if (shape.color) {
    glUniform4f(kColor, channel(shape.color->r), channel(shape.color->g), channel(shape.color->b), 1);
  } else {
    glUniform4f(kColor, 0.5F, 0.5F, 0.5F, 0.5F);
  }
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace meshloop
