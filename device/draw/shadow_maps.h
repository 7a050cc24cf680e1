#pragma once
// What the light sees: the depth of the virtual objects and that of the model, around the objects.
#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "common/gpu/gl_objects.h"
#include "common/gpu/mesh_cache.h"
#include "device/draw/object_cache.h"

namespace meshloop {

/// One far lamp above, a little to the side so that shadows show. z of the world is up.
[[nodiscard]] Eigen::Vector3d direction_to_light();

/// The box in which shadows are looked for, seen along the light. It is just wide enough for the virtual objects: only
/// what they shade, and what shades them, matters.
struct ShadowBox {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// Columns: the map's x, its y, and the direction in which the light goes; in the world.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  double half_width_m = 0;
  /// Along the light, from the centre.
  double near_m = 0;
  double far_m = 0;

  [[nodiscard]] Eigen::Matrix4d clip_from_world() const;
  /// The nearest of the objects, along the light: only what lies farther can be in their shadow.
  double first_caster_m = 0;
  /// Of the part behind the first caster, in the world: all that the objects can shade lies between them.
  [[nodiscard]] std::vector<Eigen::Vector3d> shaded_corners() const;
};

/// Both maps have one size and one box. They are drawn anew only when the objects or the model have changed: they do
/// not depend on the camera. One thread, that of the context, which is current in every call and at the end.
class ShadowMaps {
 public:
  [[nodiscard]] static Result<ShadowMaps> create();

  void update(const Model& model, const std::vector<const VirtualObject*>& objects, const ObjectCache& cache,
              MeshCache& model_meshes);

  [[nodiscard]] const Texture& of_objects() const { return of_objects_; }
  [[nodiscard]] const Texture& of_model() const { return of_model_; }
  [[nodiscard]] const ShadowBox& box() const { return box_; }
  /// How often the maps were drawn.
  [[nodiscard]] int drawn() const { return drawn_; }

 private:
  /// Geometry and place of everything in a map.
  using Content = std::vector<std::pair<std::shared_ptr<const Submesh>, Eigen::Matrix4d>>;

  explicit ShadowMaps(Program program);
  void draw_objects(const std::vector<const VirtualObject*>& objects, const ObjectCache& cache) const;
  void draw_model(const Model& model, MeshCache& model_meshes) const;

  Program program_;
  Texture of_objects_;
  Texture of_model_;
  Framebuffer framebuffer_;
  ShadowBox box_;
  Content objects_content_;
  Content model_content_;
  int drawn_ = 0;
};

}  // namespace meshloop
