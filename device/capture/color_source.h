#pragma once
#include <memory>
#include <optional>

#include "common/base/result.h"
#include "common/geometry/camera.h"
#include "common/image/frames.h"

namespace meshloop {

/// Where the handheld's pictures come from. Frames are free of lens distortion.
class ColorSource {
 public:
  virtual ~ColorSource() = default;
  [[nodiscard]] virtual const Camera& camera() const = 0;
  /// The next frame; nothing at the end.
  [[nodiscard]] virtual Result<std::optional<ColorFrame>> next() = 0;
};

}  // namespace meshloop
