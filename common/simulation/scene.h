#pragma once
// A virtual scene of simple solids with exact surfaces: the ground truth for everything.
#include <Eigen/Geometry>
#include <functional>
#include <string>
#include <vector>

#include "common/geometry/pose.h"
#include "common/image/image.h"
#include "common/mesh/submesh.h"

namespace meshloop::simulation {

/// Colour of a point of a solid, in the solid's frame.
using Texture = std::function<Rgb8(const Eigen::Vector3d& p_solid, const Eigen::Vector3d& normal_solid)>;

/// An axis-aligned box, or a cylinder along z, centred in its own frame.
struct Solid {
  enum class Shape { box, cylinder };
  std::string name;
  Shape shape = Shape::box;
  /// Full extents; a cylinder's diameter is x, its height z.
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  Pose T_world_solid = Pose::Identity();
  Texture texture;
  /// Colours of the model's vertices where the model knows less than reality shows; empty: the same as `texture`.
  Texture mesh_texture;
  /// Edges of the model's triangles are this many times shorter than asked for.
  double mesh_detail = 1;
  /// Part of the shared model from the start.
  bool modelled = false;
  /// The object it belongs to ("box", "car", "bricks"), for moving all of it.
  std::string object;
};

struct Scene {
  std::vector<Solid> solids;
  /// Colour of the far room in a direction (world frame); too far away for any depth sensor.
  std::function<Rgb8(const Eigen::Vector3d& direction)> background;
};

/// The demo's scene: toy bricks and a sideboard (modelled), a textured box and a small car (not), markers on the
/// sideboard. z is up, the sideboard's top is z = 0, its centre the origin. `seed` varies textures.
[[nodiscard]] Scene make_demo_scene(unsigned seed);
/// The same with all solids of an object moved.
[[nodiscard]] Scene with_moved_object(Scene scene, const std::string& object, const Eigen::Vector3d& offset_m);
/// The modelled solids (or all of them) as triangles with vertex colours, edges at most `edge_m` long; a submesh an
/// object.
struct SolidMesh {
  std::string name;
  Submesh submesh;
};
[[nodiscard]] std::vector<SolidMesh> tessellate(const Scene& scene, bool modelled_only, double edge_m);

}  // namespace meshloop::simulation
