#pragma once
// A window of the depth image. Flat arrays, row by row.
#include <cstdint>
#include <vector>

#include "common/change/comparison.h"
#include "common/change/region.h"
#include "common/geometry/sensor_model.h"
#include "common/image/image.h"

namespace meshloop::adjust {

/// Columns x0 to x1 - 1, rows y0 to y1 - 1 of an image.
struct Window {
  int x0 = 0;
  int y0 = 0;
  int x1 = 0;
  int y1 = 0;
  [[nodiscard]] int width() const { return x1 - x0; }
  [[nodiscard]] int height() const { return y1 - y0; }
  [[nodiscard]] bool empty() const { return x1 <= x0 || y1 <= y0; }
  [[nodiscard]] std::size_t size() const {
    return empty() ? 0 : static_cast<std::size_t>(width()) * static_cast<std::size_t>(height());
  }
};

/// The pixels of a region and one more to each side; empty when the region has none.
[[nodiscard]] Window window_of(const Image<RegionId>& ids, RegionId region);

/// What a pixel is to a patch: a part of it, also where nothing was measured (gap), or beside it, at its measured or at
/// the model's depth.
enum class Role : std::uint8_t { outside, rim, model_rim, gap, member };

[[nodiscard]] constexpr bool is_part(Role role) {
  return role == Role::member || role == Role::gap;
}

/// Depths of a window, with their role in a patch.
struct DepthGrid {
  Window window;
  /// Metres; 0 where the role is outside.
  std::vector<float> z;
  /// Sensor noise in metres, frontal view; 0 where the role is outside.
  std::vector<float> sigma;
  std::vector<Role> role;
  /// Standard deviation of where in the picture a depth was measured, in pixels.
  double lateral_px = 0;
};

/// Members are the region's pixels that ask for an insertion; the rim is what agrees or is undecided right beside them.
/// `measurements`: of how many each depth is the mean; empty: of one.
[[nodiscard]] DepthGrid select_patch(const Comparison& comparison, const DepthImage& measured,
                                     const Image<std::uint8_t>& measurements, const Image<RegionId>& ids,
                                     RegionId region, const SensorModel& sensor);

/// One bilateral pass over the members: neighbours in a 5x5 window count less the farther away they are, and not at all
/// beyond five sigma of depth. `measured` is the whole frame, so that a patch's border is smoothed like its middle.
void smooth(DepthGrid& grid, const DepthImage& measured);

/// Depth by which a surface seen at 80 degrees changes from one pixel to the next, per metre of distance and for a
/// focal length of one pixel.
inline constexpr double kSteepest = 5.671281819617709;  // tan(80 degrees)

}  // namespace meshloop::adjust
