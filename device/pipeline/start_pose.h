#pragma once
#include <optional>
#include <string>

#include "common/features/markers.h"
#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/image/frames.h"

namespace meshloop {

/// Where a tracker that knows nothing begins: a given pose, or markers that are in the picture.
class StartPose {
 public:
  /// `pose:tx,ty,tz,qx,qy,qz,qw` (camera to world) or `markers:FILE`.
  [[nodiscard]] static Result<StartPose> parse(const std::string& text);

  /// T_camera_world. A given pose holds for the first frame only; markers help at any time.
  [[nodiscard]] std::optional<Pose> find(const ColorFrame& frame, const Camera& camera);

 private:
  std::optional<Pose> given_;
  std::optional<MarkerMap> markers_;
  std::optional<MarkerDetector> detector_;
};

inline constexpr const char* kInitHelp =
    "where tracking begins: pose:tx,ty,tz,qx,qy,qz,qw (camera to world) or markers:FILE";

}  // namespace meshloop
