#pragma once
// Draws the model as a depth, node and colour image from a pinhole camera.
#include <memory>
#include <optional>

#include "common/base/result.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/gpu/context.h"
#include "common/gpu/mesh_cache.h"
#include "common/gpu/screen_area.h"
#include "common/image/image.h"
#include "common/mesh/model.h"

namespace meshloop {

struct SceneView {
  /// Lens distortion is ignored.
  Camera camera;
  Pose T_camera_world = Pose::Identity();
  /// Metres along the optical axis.
  float near_m = 0.05f;
  float far_m = 50.0f;
  /// Only these pixels are drawn when it is given; what the textures hold elsewhere is left open. Not empty, and within
  /// the picture.
  std::optional<ScreenArea> area = std::nullopt;
  /// Textures that are not wanted are left alone, which saves a part of the time.
  bool nodes = true;
  bool color = true;
  /// How far the drawn surfaces may lie from the model's, for the sake of speed. Colours of vertices are right only
  /// when it is exact.
  Tolerance tolerance;
};

/// Renders into its own targets, which grow to the camera's size. One thread, that of the context.
///
/// Row 0 of the textures is row 0 (the top) of the image. Depth texture: R32F, metres along the optical axis, 0 where
/// no surface is. Node texture: R32UI, position in Model::nodes plus 1, 0 for none. Colour texture: RGBA8, the vertex
/// colours or the texture's (common/mesh/texture.h) as they are (no light), alpha 0 where no surface is, 1 where the
/// node has colours and 0.5 where it has none (drawn mid grey). Both sides of a triangle are drawn. A node with a shape
/// is drawn by its formula, not by its triangles: see implicit_renderer.h for how exact its depth is.
class SceneRenderer {
 public:
  [[nodiscard]] static Result<std::unique_ptr<SceneRenderer>> create(GpuContext& context);
  virtual ~SceneRenderer() = default;

  /// Uploads what is new, then draws. The textures hold the result until the next call.
  virtual void render(const Model& model, const SceneView& view) = 0;

  /// GL names, for shaders that go on with them.
  [[nodiscard]] virtual unsigned depth_texture() const = 0;
  [[nodiscard]] virtual unsigned node_texture() const = 0;
  [[nodiscard]] virtual unsigned color_texture() const = 0;

  /// Waits for the drawing and copies.
  [[nodiscard]] virtual DepthImage read_depth() = 0;
  [[nodiscard]] virtual Image<std::uint32_t> read_nodes() = 0;
  /// RGB of the colour texture; mask (when not null) becomes 255 where alpha is 1, else 0.
  [[nodiscard]] virtual ColorImage read_color(GreyImage* mask) = 0;
};

}  // namespace meshloop
