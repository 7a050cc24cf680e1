#include "common/gpu/scene_renderer.h"

#include <array>
#include <optional>
#include <utility>

#include "common/gpu/gl_objects.h"
#include "common/gpu/implicit_renderer.h"
#include "common/gpu/projection.h"
#include "shaders/shaders.h"

namespace meshloop {
namespace {

constexpr GLint kClipFromNode = 0;
constexpr GLint kNodeIndex = 1;
constexpr GLint kPictureFromNode = 2;
constexpr GLuint kColorAttribute = 1;

struct Targets {
  int width;
  int height;
  Texture depth;
  Texture node;
  Texture color;
  Texture z_buffer;
  Framebuffer framebuffer;

  Targets(int wide, int high)
      : width{wide},
        height{high},
        depth{make_texture(GL_R32F, wide, high)},
        node{make_texture(GL_R32UI, wide, high)},
        color{make_texture(GL_RGBA8, wide, high)},
        z_buffer{make_texture(GL_DEPTH_COMPONENT32F, wide, high)} {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    attach(GL_COLOR_ATTACHMENT0, depth);
    attach(GL_COLOR_ATTACHMENT1, node);
    attach(GL_COLOR_ATTACHMENT2, color);
    attach(GL_DEPTH_ATTACHMENT, z_buffer);
  }

  /// Binds them for drawing.
  void bind(bool with_nodes, bool with_color) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    const std::array<GLenum, 3> wanted{GL_COLOR_ATTACHMENT0, with_nodes ? GL_COLOR_ATTACHMENT1 : GLenum{GL_NONE},
                                       with_color ? GL_COLOR_ATTACHMENT2 : GLenum{GL_NONE}};
    glDrawBuffers(static_cast<GLsizei>(wanted.size()), wanted.data());
  }

 private:
  static void attach(GLenum attachment, const Texture& texture) {
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture.name(), 0);
  }
};

struct Programs {
  Program with_color;
  Program with_texture;
  Program geometry_alone;
};

class GlSceneRenderer final : public SceneRenderer {
 public:
  GlSceneRenderer(GpuContext& context, Programs programs, ImplicitRenderer shapes, Targets targets)
      : context_{context}, programs_{std::move(programs)}, shapes_{std::move(shapes)}, targets_{std::move(targets)} {}
  GlSceneRenderer(const GlSceneRenderer&) = delete;
  GlSceneRenderer& operator=(const GlSceneRenderer&) = delete;
  // The members are freed in the context that made them.
  ~GlSceneRenderer() override { context_.make_current(); }

  void render(const Model& model, const SceneView& view) override;

  [[nodiscard]] unsigned depth_texture() const override { return targets_.depth.name(); }
  [[nodiscard]] unsigned node_texture() const override { return targets_.node.name(); }
  [[nodiscard]] unsigned color_texture() const override { return targets_.color.name(); }

  [[nodiscard]] DepthImage read_depth() override;
  [[nodiscard]] Image<std::uint32_t> read_nodes() override;
  [[nodiscard]] ColorImage read_color(GreyImage* mask) override;

 private:
  void prepare(const SceneView& view);
  void draw_nodes(const Model& model, const SceneView& view) const;
  bool use_picture(const Node& node) const;

  GpuContext& context_;
  Programs programs_;
  ImplicitRenderer shapes_;
  Targets targets_;
};

void clear_targets(bool with_nodes, bool with_color) {
  constexpr std::array<float, 4> kNoDepth{0, 0, 0, 0};
  constexpr std::array<GLuint, 4> kNoNode{0, 0, 0, 0};
  constexpr std::array<float, 4> kNoColor{0, 0, 0, 0};
  constexpr float kFarthest = 1;
  glClearBufferfv(GL_COLOR, 0, kNoDepth.data());
  glClearBufferfv(GL_DEPTH, 0, &kFarthest);
  if (with_nodes) glClearBufferuiv(GL_COLOR, 1, kNoNode.data());
  if (with_color) glClearBufferfv(GL_COLOR, 2, kNoColor.data());
}

// Everything that the drawing depends on is set here: the context is shared with other drawing.
void GlSceneRenderer::prepare(const SceneView& view) {
  const Camera& camera = view.camera;
  if (camera.width != targets_.width || camera.height != targets_.height) {
    targets_ = Targets(camera.width, camera.height);
  }
  targets_.bind(view.nodes, view.color);
  glViewport(0, 0, targets_.width, targets_.height);
  if (view.area) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(view.area->x, view.area->y, view.area->width, view.area->height);
  } else {
    glDisable(GL_SCISSOR_TEST);
  }
  for (const GLenum off :
       std::initializer_list<GLenum>{GL_CULL_FACE, GL_BLEND, GL_STENCIL_TEST, GL_DITHER, GL_POLYGON_OFFSET_FILL,
                                     GL_RASTERIZER_DISCARD, GL_SAMPLE_ALPHA_TO_COVERAGE}) {
    glDisable(off);
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDepthRangef(0, 1);
}

void GlSceneRenderer::render(const Model& model, const SceneView& view) {
  context_.make_current();
  prepare(view);
  context_.meshes().update(model, !view.tolerance.is_exact());
  clear_targets(view.nodes, view.color);
  draw_nodes(model, view);
  shapes_.draw(model, view);
  glBindVertexArray(0);
  glDisable(GL_SCISSOR_TEST);
  glFlush();
}

void GlSceneRenderer::draw_nodes(const Model& model, const SceneView& view) const {
  const Eigen::Matrix4d clip_from_world =
      clip_from_camera(view.camera, view.near_m, view.far_m) * view.T_camera_world.matrix();
  const Eigen::Matrix4d part_from_clip =
      view.area ? clip_of_part(*view.area, view.camera) : Eigen::Matrix4d::Identity();
  const Program& plain = view.color ? programs_.with_color : programs_.geometry_alone;
  plain.use();
  glVertexAttrib4f(kColorAttribute, 0.5F, 0.5F, 0.5F, 0.5F);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const Node& node = model.nodes[i];
    if (node.shape) continue;
    // The product is made in double: a float camera far from the origin would move what it sees.
    const Eigen::Matrix4d clip_from_node = clip_from_world * node.T_world_node.matrix();
    const Eigen::Matrix4f matrix = clip_from_node.cast<float>();
    const bool has_picture = view.color && use_picture(node);
    glUniformMatrix4fv(kClipFromNode, 1, GL_FALSE, matrix.data());
    glUniform1ui(kNodeIndex, static_cast<GLuint>(i + 1));
    context_.meshes().draw(node, part_from_clip * clip_from_node, view.tolerance);
    if (has_picture) plain.use();
  }
}

bool GlSceneRenderer::use_picture(const Node& node) const {
  if (!node.submesh || !node.submesh->texture) return false;
  glActiveTexture(GL_TEXTURE0);
  if (context_.meshes().bind_picture(node) == 0) return false;
  programs_.with_texture.use();
  const TextureProjection& projection = node.submesh->texture->projection;
  glUniformMatrix4x3fv(kPictureFromNode, 1, GL_FALSE, projection.data());
  return true;
}

DepthImage GlSceneRenderer::read_depth() {
  context_.make_current();
  DepthImage depth(targets_.width, targets_.height);
  read_floats(targets_.framebuffer, GL_COLOR_ATTACHMENT0, targets_.width, targets_.height, depth.data());
  return depth;
}

Image<std::uint32_t> GlSceneRenderer::read_nodes() {
  context_.make_current();
  Image<std::uint32_t> nodes(targets_.width, targets_.height);
  read_unsigned(targets_.framebuffer, GL_COLOR_ATTACHMENT1, targets_.width, targets_.height, nodes.data());
  return nodes;
}

ColorImage GlSceneRenderer::read_color(GreyImage* mask) {
  context_.make_current();
  const int width = targets_.width;
  const int height = targets_.height;
  Image<std::array<std::uint8_t, 4>> rgba(width, height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets_.framebuffer.name());
  glReadBuffer(GL_COLOR_ATTACHMENT2);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  ColorImage color(width, height);
  if (mask != nullptr) *mask = GreyImage(width, height);
  for (std::size_t i = 0; i < color.size(); ++i) {
    const auto [r, g, b, a] = rgba.pixels()[i];
    color.pixels()[i] = {r, g, b};
    if (mask != nullptr) mask->pixels()[i] = a == 255 ? 255 : 0;
  }
  return color;
}

}  // namespace

Result<std::unique_ptr<SceneRenderer>> SceneRenderer::create(GpuContext& context) {
  constexpr int kFirstSize = 16;
  context.make_current();
  auto with_color = Program::create(shaders::scene_vert, shaders::scene_frag);
  if (!with_color) return fail("preparing the scene renderer", with_color.error());
  auto with_texture = Program::create(shaders::scene_texture_vert, shaders::scene_texture_frag);
  if (!with_texture) return fail("preparing the scene renderer", with_texture.error());
  auto geometry_alone = Program::create(shaders::scene_geometry_vert, shaders::scene_geometry_frag);
  if (!geometry_alone) return fail("preparing the scene renderer", geometry_alone.error());
  auto shapes = ImplicitRenderer::create();
  if (!shapes) return fail("preparing the scene renderer", shapes.error());
  Targets targets(kFirstSize, kFirstSize);
  targets.bind(true, true);
  if (auto usable = check_framebuffer("float depth images"); !usable) return fail(usable.error());
  return std::unique_ptr<SceneRenderer>{std::make_unique<GlSceneRenderer>(
      context, Programs{std::move(*with_color), std::move(*with_texture), std::move(*geometry_alone)},
      std::move(*shapes), std::move(targets))};
}

}  // namespace meshloop
