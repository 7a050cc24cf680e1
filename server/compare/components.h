#pragma once
// Connected pixels of one kind of change.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/change/label.h"
#include "common/image/image.h"

namespace meshloop {

/// Which component each changed pixel belongs to.
struct Components {
  /// 1 to `count`; 0 where nothing changed.
  Image<std::uint32_t> numbers;
  std::uint32_t count = 0;
  /// Positions in the image of the changed pixels, row by row.
  std::vector<std::size_t> pixels;
};

/// Pixels of one kind belong together when they touch, also at a corner, or when one pixel of another kind lies between
/// them: a line of dropouts does not cut a region in two.
[[nodiscard]] Components connect_changes(const Image<Label>& labels);

}  // namespace meshloop
