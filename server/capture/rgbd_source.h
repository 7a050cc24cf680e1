#pragma once
#include <memory>
#include <optional>

#include "common/base/result.h"
#include "common/geometry/rig.h"
#include "common/image/frames.h"

namespace meshloop {

/// Where depth and colour come from. Frames are free of lens distortion.
class RgbdSource {
 public:
  virtual ~RgbdSource() = default;
  /// Cameras without distortion, as the frames are.
  [[nodiscard]] virtual const Rig& rig() const = 0;
  /// The rig as calibrated, with the lens distortion that the frames were made free of.
  [[nodiscard]] virtual const Rig& calibration() const = 0;
  /// The next frame; nothing at the end of a recording. A frame that cannot be read is an error; the source can go on.
  [[nodiscard]] virtual Result<std::optional<RgbdFrame>> next() = 0;
  /// How many frames there are in all, where that is known.
  [[nodiscard]] virtual std::optional<int> frame_count() const { return std::nullopt; }
  /// Whether `next` has something to give without waiting for a camera or a recording's pace.
  [[nodiscard]] virtual bool ready() const { return true; }
};

}  // namespace meshloop
