#pragma once
// The augmented view: camera image, virtual objects hidden by the real scene, shadows on it.
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/gpu/context.h"
#include "common/image/image.h"
#include "common/mesh/model.h"

namespace meshloop {

/// An object that is not there.
struct VirtualObject {
  std::shared_ptr<const Submesh> submesh;
  Pose T_world_object = Pose::Identity();
};

/// What the head-up display says.
struct HudState {
  /// 0 (a model from a file, or none) is left out.
  Revision revision = 0;
  std::string tracking;
  double frames_per_s = 0;
};

struct ArFrame {
  const ColorImage* camera_image = nullptr;
  Camera camera;
  Pose T_camera_world = Pose::Identity();
  /// False: the pose is lost; only the camera image and the head-up display are drawn.
  bool tracked = false;
  const Model* model = nullptr;
  const std::vector<VirtualObject>* objects = nullptr;
  HudState hud;
};

/// Draws offscreen in the camera's size. One thread, that of the context.
class ArRenderer {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ArRenderer>> create(GpuContext& context);
  virtual ~ArRenderer() = default;
  /// Draws and reads back.
  virtual ColorImage draw(const ArFrame& frame) = 0;
};

}  // namespace meshloop
