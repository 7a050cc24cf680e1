#pragma once
#include <cstdint>
#include <memory>

#include "common/base/result.h"
#include "common/change/comparison.h"
#include "common/geometry/rig.h"
#include "common/gpu/context.h"
#include "common/image/image.h"

namespace meshloop::show {

/// Finds out which depth pixel each pixel of the colour camera sees. One thread, that of the context.
class Carrier {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Carrier>> create(GpuContext& context);
  virtual ~Carrier() = default;

  /// For each pixel of the colour image: position in the depth image of what it sees, plus 1; 0 where that is unknown.
  ///
  /// Each measured pixel is a small piece of surface, which meets those neighbours that lie on the same surface; the
  /// nearest piece wins. Where no measurement lands, unmeasured pixels are drawn at the model's depth, so that a
  /// missing measurement shows on the surface that was expected. The comparison's images and `measured` have the size
  /// of rig.depth. Refuses what the graphics driver has no room for.
  [[nodiscard]] virtual Result<Image<std::uint32_t>> carry(const Comparison& comparison, const DepthImage& measured,
                                                           const Rig& rig) = 0;
};

}  // namespace meshloop::show
