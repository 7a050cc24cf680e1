#include "device/draw/shadow_maps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shaders/shaders.h"

namespace meshloop {
namespace {

constexpr int kSize = 1024;
constexpr double kMargin_m = 0.02;
/// A caster farther away than this from the objects is not looked for.
constexpr double kFarthest_m = 20;
constexpr GLint kClipFromMesh = 0;

Eigen::Vector3d corner_of(const Eigen::AlignedBox3f& box, int i) {
  return box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i)).cast<double>();
}

/// Smallest and largest distance along a direction, from a centre.
struct Reach {
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -std::numeric_limits<double>::infinity();

  void extend(const Eigen::AlignedBox3f& box, const Pose& T_world_box, const Eigen::Vector3d& centre,
              const Eigen::Vector3d& direction) {
    for (int i = 0; i < 8; ++i) {
      const double along = direction.dot(T_world_box * corner_of(box, i) - centre);
      nearest = std::min(nearest, along);
      farthest = std::max(farthest, along);
    }
  }
};

Eigen::Matrix3d light_axes() {
  Eigen::Matrix3d axes;
  axes.col(2) = -direction_to_light();
  axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitY()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

ShadowBox box_around(const Model& model, const std::vector<const VirtualObject*>& objects, const ObjectCache& cache,
                     const MeshCache& model_meshes) {
  Eigen::AlignedBox3d hull;
  for (const auto* object : objects) {
    for (int i = 0; i < 8; ++i) hull.extend(object->T_world_object * corner_of(cache.mesh_of(*object).bounds, i));
  }
  ShadowBox box;
  box.axes = light_axes();
  box.centre = hull.center();
  box.half_width_m = hull.diagonal().norm() / 2 + kMargin_m;
  const Eigen::Vector3d direction = box.axes.col(2);
  Reach reach;
  for (const auto* object : objects) {
    reach.extend(cache.mesh_of(*object).bounds, object->T_world_object, box.centre, direction);
  }
  box.first_caster_m = std::max(reach.nearest, -kFarthest_m) - kMargin_m;
  for (const auto& node : model.nodes) {
    const GpuMesh& mesh = model_meshes.mesh_of(node);
    if (mesh.index_count > 0) reach.extend(mesh.bounds, node.T_world_node, box.centre, direction);
  }
  box.near_m = std::max(reach.nearest, -kFarthest_m) - kMargin_m;
  box.far_m = std::min(reach.farthest, kFarthest_m) + kMargin_m;
  return box;
}

void begin_map(const Framebuffer& framebuffer, const Texture& map) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, map.name(), 0);
  const GLenum no_color = GL_NONE;
  glDrawBuffers(1, &no_color);
  glViewport(0, 0, kSize, kSize);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  const float farthest = 1;
  glClearBufferfv(GL_DEPTH, 0, &farthest);
}

void set_place(const Eigen::Matrix4d& clip_from_mesh) {
  const Eigen::Matrix4f matrix = clip_from_mesh.cast<float>();
  glUniformMatrix4fv(kClipFromMesh, 1, GL_FALSE, matrix.data());
}

}  // namespace

Eigen::Vector3d direction_to_light() {
  return Eigen::Vector3d{-0.50, -0.26, 0.83}.normalized();
}

Eigen::Matrix4d ShadowBox::clip_from_world() const {
  Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
  clip.row(0).head<3>() = axes.col(0).transpose() / half_width_m;
  clip.row(1).head<3>() = axes.col(1).transpose() / half_width_m;
  clip.row(2).head<3>() = axes.col(2).transpose() * 2 / (far_m - near_m);
  clip.col(3).head<3>() = -clip.topLeftCorner<3, 3>() * centre;
  clip(2, 3) -= (far_m + near_m) / (far_m - near_m);
  return clip;
}

std::vector<Eigen::Vector3d> ShadowBox::shaded_corners() const {
  std::vector<Eigen::Vector3d> corners;
  for (const double x : {-half_width_m, half_width_m}) {
    for (const double y : {-half_width_m, half_width_m}) {
      for (const double z : {first_caster_m, far_m}) corners.emplace_back(centre + axes * Eigen::Vector3d{x, y, z});
    }
  }
  return corners;
}

ShadowMaps::ShadowMaps(Program program)
    : program_{std::move(program)},
      of_objects_{make_texture(GL_DEPTH_COMPONENT32F, kSize, kSize)},
      of_model_{make_texture(GL_DEPTH_COMPONENT32F, kSize, kSize)} {}

Result<ShadowMaps> ShadowMaps::create() {
  auto program = Program::create(shaders::ar_shadow_vert, shaders::ar_shadow_frag);
  if (!program) return fail("preparing the shadows", program.error());
  ShadowMaps maps{std::move(*program)};
  begin_map(maps.framebuffer_, maps.of_objects_);
  if (auto usable = check_framebuffer("shadow maps"); !usable) return fail(usable.error());
  return maps;
}

void ShadowMaps::draw_objects(const std::vector<const VirtualObject*>& objects, const ObjectCache& cache) const {
  begin_map(framebuffer_, of_objects_);
  for (const auto* object : objects) {
    const ObjectMesh& mesh = cache.mesh_of(*object);
    set_place(box_.clip_from_world() * object->T_world_object.matrix());
    glBindVertexArray(mesh.vertex_array.name());
    glDrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
  }
}

void ShadowMaps::draw_model(const Model& model, MeshCache& model_meshes) const {
  begin_map(framebuffer_, of_model_);
  for (const auto& node : model.nodes) {
    const Eigen::Matrix4d clip_from_node = box_.clip_from_world() * node.T_world_node.matrix();
    set_place(clip_from_node);
    model_meshes.draw(node, clip_from_node, Tolerance{});
  }
}

void ShadowMaps::update(const Model& model, const std::vector<const VirtualObject*>& objects, const ObjectCache& cache,
                        MeshCache& model_meshes) {
  Content objects_content;
  for (const auto* object : objects) objects_content.emplace_back(object->submesh, object->T_world_object.matrix());
  Content model_content;
  for (const auto& node : model.nodes) model_content.emplace_back(node.submesh, node.T_world_node.matrix());
  if (drawn_ > 0 && objects_content == objects_content_ && model_content == model_content_) return;
  model_meshes.update(model, false);
  box_ = box_around(model, objects, cache, model_meshes);
  program_.use();
  draw_objects(objects, cache);
  draw_model(model, model_meshes);
  glBindVertexArray(0);
  objects_content_ = std::move(objects_content);
  model_content_ = std::move(model_content);
  ++drawn_;
}

}  // namespace meshloop
