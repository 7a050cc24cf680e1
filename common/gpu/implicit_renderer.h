#pragma once
// Shapes drawn by their formulas, beside the triangles.
#include "common/base/result.h"
#include "common/gpu/gl_objects.h"
#include "common/implicit/shape.h"
#include "common/mesh/model.h"

namespace meshloop {

struct SceneView;

/// Draws the nodes of a model that have a shape into the targets that SceneRenderer has bound, with its depth test: a
/// ray a pixel, through the middle of the pixel, to the first surface between the view's near and far distance, seen
/// from outside or inside. Depth is within 0.1 mm of common/implicit/cast_ray.h at up to 3 m, but for rays that graze a
/// curved surface: there a ray moved by some micrometres has another depth as well. One thread, that of the context,
/// which must be current.
class ImplicitRenderer {
 public:
  [[nodiscard]] static Result<ImplicitRenderer> create();

  void draw(const Model& model, const SceneView& view) const;

 private:
  explicit ImplicitRenderer(Program program) : program_{std::move(program)} {}
  void draw_shape(const Shape& shape, const Pose& T_world_node, unsigned node_index, const SceneView& view) const;

  Program program_;
  VertexArray no_vertices_;
  Buffer block_;
};

}  // namespace meshloop
