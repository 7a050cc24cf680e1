#include "device/draw/ar_renderer.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "common/gpu/gl_objects.h"
#include "common/gpu/projection.h"
#include "common/gpu/scene_renderer.h"
#include "common/gpu/screen_area.h"
#include "device/draw/hud.h"
#include "device/draw/object_cache.h"
#include "device/draw/shadow_maps.h"
#include "shaders/shaders.h"

namespace meshloop {
namespace {

constexpr int kSamples = 4;
constexpr float kNear_m = 0.02f;
constexpr float kFar_m = 50.0f;
constexpr std::array<float, 4> kNothing{0, 0, 0, 0};
// Uniform locations, as in the shaders.
constexpr GLint kWorldFromObject = 0;
constexpr GLint kCameraFromObject = 1;
constexpr GLint kClipFromCamera = 2;
constexpr GLint kCameraWorld = 3;
constexpr GLint kWorldFromCamera = 0;
constexpr GLint kIntrinsics = 1;
constexpr GLint kShadowFromWorld = 20;
constexpr GLint kLightAxes = 21;
constexpr GLint kShadowExtent = 22;

Texture make_multisampled(GLenum internal_format, int width, int height) {
  Texture texture;
  glBindTexture(GL_TEXTURE_2D_MULTISAMPLE, texture.name());
  glTexStorage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, kSamples, internal_format, width, height, GL_TRUE);
  return texture;
}

/// Everything of the picture's size.
struct Targets {
  int width;
  int height;
  Texture camera_picture;
  Texture layer_samples;
  Texture layer_depth;
  Texture layer;
  Texture picture;
  Framebuffer layer_samples_target;
  Framebuffer layer_target;
  Framebuffer picture_target;

  Targets(int wide, int high)
      : width{wide},
        height{high},
        camera_picture{make_texture(GL_RGB8, wide, high)},
        layer_samples{make_multisampled(GL_RGBA8, wide, high)},
        layer_depth{make_multisampled(GL_DEPTH_COMPONENT24, wide, high)},
        layer{make_texture(GL_RGBA8, wide, high)},
        picture{make_texture(GL_RGBA8, wide, high)} {
    attach(layer_target, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, layer);
    attach(picture_target, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, picture);
    attach(layer_samples_target, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D_MULTISAMPLE, layer_samples);
    attach(layer_samples_target, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D_MULTISAMPLE, layer_depth);
  }

 private:
  static void attach(const Framebuffer& target, GLenum attachment, GLenum kind, const Texture& texture) {
    glBindFramebuffer(GL_FRAMEBUFFER, target.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, kind, texture.name(), 0);
  }
};

void bind_texture(GLuint unit, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D, texture);
}

/// Only this part of the picture is drawn from here on.
void restrict_to(const ScreenArea& area) {
  glEnable(GL_SCISSOR_TEST);
  glScissor(area.x, area.y, area.width, area.height);
}

void set_matrix(GLint location, const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix4f values = matrix.cast<float>();
  glUniformMatrix4fv(location, 1, GL_FALSE, values.data());
}

void set_light(const ShadowBox& box) {
  const Eigen::Affine3d texture_from_clip = Eigen::Translation3d(0.5, 0.5, 0.5) * Eigen::Scaling(0.5);
  set_matrix(kShadowFromWorld, texture_from_clip.matrix() * box.clip_from_world());
  const Eigen::Matrix3f axes = box.axes.cast<float>();
  glUniformMatrix3fv(kLightAxes, 1, GL_FALSE, axes.data());
  glUniform2f(kShadowExtent, static_cast<float>(2 * box.half_width_m), static_cast<float>(box.far_m - box.near_m));
}

void upload_part(const Texture& texture, const ColorImage& picture, const ScreenArea& area) {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, picture.width());
  glTexSubImage2D(GL_TEXTURE_2D, 0, area.x, area.y, area.width, area.height, GL_RGB, GL_UNSIGNED_BYTE,
                  &picture(area.x, area.y));
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
}

void read_part(const Framebuffer& source, ColorImage& picture, const ScreenArea& area) {
  Image<std::array<std::uint8_t, 4>> rgba{area.width, area.height};
  glBindFramebuffer(GL_READ_FRAMEBUFFER, source.name());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glReadPixels(area.x, area.y, area.width, area.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      const auto& [r, g, b, a] = rgba(x, y);
      picture(area.x + x, area.y + y) = {r, g, b};
    }
  }
}

class GlArRenderer final : public ArRenderer {
 public:
  struct Parts {
    std::unique_ptr<SceneRenderer> scene;
    ShadowMaps shadows;
    Program object_program;
    Program composite_program;
    Targets targets;
  };
  GlArRenderer(GpuContext& context, Parts parts) : context_{context}, parts_{std::move(parts)} {}
  GlArRenderer(const GlArRenderer&) = delete;
  GlArRenderer& operator=(const GlArRenderer&) = delete;
  // The members are freed in the context that made them.
  ~GlArRenderer() override { context_.make_current(); }

  ColorImage draw(const ArFrame& frame) override;

 private:
  void augment(const ArFrame& frame, const std::vector<const VirtualObject*>& objects, ColorImage& picture);
  void bind_scene() const;
  [[nodiscard]] ScreenArea area_of(const ArFrame& frame, const std::vector<const VirtualObject*>& objects) const;
  void draw_layer(const ArFrame& frame, const std::vector<const VirtualObject*>& objects,
                  const ScreenArea& objects_area, const ScreenArea& area) const;
  void compose(const ArFrame& frame) const;

  GpuContext& context_;
  Parts parts_;
  ObjectCache object_cache_;
  VertexArray no_vertices_;
};

bool can_augment(const ArFrame& frame, const ColorImage& picture) {
  return frame.tracked && frame.objects != nullptr && !picture.empty() && picture.width() == frame.camera.width &&
         picture.height() == frame.camera.height && validate(frame.camera) && is_rigid(frame.T_camera_world);
}

ColorImage GlArRenderer::draw(const ArFrame& frame) {
  ColorImage picture = frame.camera_image != nullptr
                           ? *frame.camera_image
                           : ColorImage{std::max(0, frame.camera.width), std::max(0, frame.camera.height)};
  if (can_augment(frame, picture)) {
    context_.make_current();
    const auto objects = object_cache_.update(*frame.objects);
    if (!objects.empty()) augment(frame, objects, picture);
  }
  draw_hud(picture, frame.hud);
  return picture;
}

void GlArRenderer::augment(const ArFrame& frame, const std::vector<const VirtualObject*>& objects,
                           ColorImage& picture) {
  const Model no_model;
  const Model& model = frame.model != nullptr ? *frame.model : no_model;
  if (picture.width() != parts_.targets.width || picture.height() != parts_.targets.height) {
    parts_.targets = Targets{picture.width(), picture.height()};
  }
  parts_.shadows.update(model, objects, object_cache_, context_.meshes());
  // Outside this part the picture stays as it is, and nothing is drawn, sent or read back there.
  const ScreenArea objects_area = area_of(frame, objects);
  const ScreenArea area = joined(
      objects_area, area_of_hull(parts_.shadows.box().shaded_corners(), frame.camera, frame.T_camera_world, kNear_m));
  if (area.empty()) return;
  SceneView view;
  view.camera = frame.camera;
  view.T_camera_world = frame.T_camera_world;
  view.near_m = kNear_m;
  view.area = area;
  view.nodes = view.color = false;
  parts_.scene->render(model, view);

  upload_part(parts_.targets.camera_picture, picture, area);
  glViewport(0, 0, picture.width(), picture.height());
  draw_layer(frame, objects, objects_area, area);
  restrict_to(area);
  compose(frame);
  glDisable(GL_SCISSOR_TEST);
  read_part(parts_.targets.picture_target, picture, area);
}

ScreenArea GlArRenderer::area_of(const ArFrame& frame, const std::vector<const VirtualObject*>& objects) const {
  ScreenArea area;
  for (const auto* object : objects) {
    std::vector<Eigen::Vector3d> corners;
    append_corners(corners, object_cache_.mesh_of(*object).bounds, object->T_world_object);
    area = joined(area, area_of_hull(corners, frame.camera, frame.T_camera_world, kNear_m));
  }
  return area;
}

void GlArRenderer::bind_scene() const {
  bind_texture(0, parts_.scene->depth_texture());
  bind_texture(1, parts_.shadows.of_objects().name());
  bind_texture(2, parts_.shadows.of_model().name());
  set_light(parts_.shadows.box());
}

void GlArRenderer::draw_layer(const ArFrame& frame, const std::vector<const VirtualObject*>& objects,
                              const ScreenArea& objects_area, const ScreenArea& area) const {
  const Targets& targets = parts_.targets;
  restrict_to(area);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_target.name());
  glClearBufferfv(GL_COLOR, 0, kNothing.data());
  if (objects_area.empty()) return;
  restrict_to(objects_area);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_samples_target.name());
  constexpr float kFarthest = 1;
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glClearBufferfv(GL_COLOR, 0, kNothing.data());
  glClearBufferfv(GL_DEPTH, 0, &kFarthest);
  parts_.object_program.use();
  bind_scene();
  set_matrix(kClipFromCamera, clip_from_camera(frame.camera, kNear_m, kFar_m));
  const Eigen::Vector3f eye = frame.T_camera_world.inverse().translation().cast<float>();
  glUniform3f(kCameraWorld, eye.x(), eye.y(), eye.z());
  for (const auto* object : objects) {
    const ObjectMesh& mesh = object_cache_.mesh_of(*object);
    set_matrix(kWorldFromObject, object->T_world_object.matrix());
    set_matrix(kCameraFromObject, (frame.T_camera_world * object->T_world_object).matrix());
    glBindVertexArray(mesh.vertex_array.name());
    glDrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
  }
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.layer_samples_target.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.layer_target.name());
  const GLint right = objects_area.x + objects_area.width;
  const GLint bottom = objects_area.y + objects_area.height;
  glBlitFramebuffer(objects_area.x, objects_area.y, right, bottom, objects_area.x, objects_area.y, right, bottom,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void GlArRenderer::compose(const ArFrame& frame) const {
  const Targets& targets = parts_.targets;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.picture_target.name());
  glDisable(GL_DEPTH_TEST);
  parts_.composite_program.use();
  bind_scene();
  bind_texture(3, targets.camera_picture.name());
  bind_texture(4, targets.layer.name());
  set_matrix(kWorldFromCamera, frame.T_camera_world.inverse().matrix());
  glUniform4f(kIntrinsics, static_cast<float>(frame.camera.fx), static_cast<float>(frame.camera.fy),
              static_cast<float>(frame.camera.cx), static_cast<float>(frame.camera.cy));
  glBindVertexArray(no_vertices_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

}  // namespace

Result<std::unique_ptr<ArRenderer>> ArRenderer::create(GpuContext& context) {
  constexpr int kFirstSize = 16;
  const std::string doing = "preparing the augmented view";
  auto scene = SceneRenderer::create(context);
  if (!scene) return fail(doing, scene.error());
  context.make_current();
  auto shadows = ShadowMaps::create();
  if (!shadows) return fail(doing, shadows.error());
  auto object_program = Program::create(shaders::ar_object_vert, shaders::ar_object_frag);
  if (!object_program) return fail(doing, object_program.error());
  auto composite_program = Program::create(shaders::ar_composite_vert, shaders::ar_composite_frag);
  if (!composite_program) return fail(doing, composite_program.error());
  Targets targets{kFirstSize, kFirstSize};
  if (auto usable = check_framebuffer("multisampled pictures"); !usable) return fail(doing, usable.error());
  return std::unique_ptr<ArRenderer>{std::make_unique<GlArRenderer>(
      context, GlArRenderer::Parts{std::move(*scene), std::move(*shadows), std::move(*object_program),
                                   std::move(*composite_program), std::move(targets)})};
}

}  // namespace meshloop
