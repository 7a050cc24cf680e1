#include <algorithm>
#include <cmath>
#include <limits>

#include "common/change/classify_rule.h"
#include "server/compare/comparator.h"
#include "server/compare/compare_input.h"
#include "server/compare/pixel_uncertainty.h"

namespace meshloop {
namespace {

struct Neighbourhood {
  float nearest_m = 0;
  float farthest_m = 0;
  bool has_gap = false;
};

// The surface that is expected at the pixel itself, seen at a neighbour.
bool continues(double inverse_depth, double z_m, double threshold_m) {
  return inverse_depth > 0 && std::abs(z_m * inverse_depth - 1) <= threshold_m * inverse_depth;
}

Neighbourhood look_around(const DepthImage& expected, int u, int v, const PixelUncertainty& uncertainty) {
  const float here = expected(u, v);
  const bool is_modelled = here > 0;
  const int reach = uncertainty.reach_px;
  Neighbourhood found{here, here, !is_modelled};
  for (int y = std::max(v - reach, 0); y <= std::min(v + reach, expected.height() - 1); ++y) {
    for (int x = std::max(u - reach, 0); x <= std::min(u + reach, expected.width() - 1); ++x) {
      const float z = expected(x, y);
      if (!(z > 0)) {
        found.has_gap = true;
        continue;
      }
      const double inverse_depth =
          1 / static_cast<double>(here) + uncertainty.inverse_depth_slope.dot(Eigen::Vector2d(x - u, y - v));
      if (!is_modelled || !continues(inverse_depth, static_cast<double>(z), uncertainty.threshold_m)) {
        found.nearest_m = found.nearest_m > 0 ? std::min(found.nearest_m, z) : z;
        found.farthest_m = std::max(found.farthest_m, z);
      }
    }
  }
  return found;
}

}  // namespace

Comparison compare_on_cpu(const CompareInput& input, const DepthImage& expected,
                          const Image<std::uint32_t>& node_index) {
  const int width = expected.width();
  const int height = expected.height();
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  constexpr float kUnknown = std::numeric_limits<float>::infinity();
  Comparison result{Image<Label>(width, height), Image<float>(width, height, kNothing), expected, node_index,
                    Image<float>(width, height, kUnknown)};
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const float measured_m = usable_depth((*input.measured)(u, v));
      if (measured_m <= 0) continue;
      const float expected_m = expected(u, v);
      const auto uncertainty = pixel_uncertainty(input, expected, u, v, static_cast<double>(measured_m));
      const auto threshold_m = static_cast<float>(uncertainty.threshold_m);
      const bool is_known = !rule::needs_neighbourhood(measured_m, expected_m, threshold_m);
      const auto [nearest, farthest, has_gap] = is_known ? Neighbourhood{expected_m, expected_m, !(expected_m > 0)}
                                                         : look_around(expected, u, v, uncertainty);
      result.labels(u, v) =
          static_cast<Label>(rule::classify(measured_m, expected_m, threshold_m, nearest, farthest, has_gap));
      if (expected_m > 0) result.difference_m(u, v) = measured_m - expected_m;
      if (threshold_m < rule::kNoThreshold_m) result.threshold_m(u, v) = threshold_m;
    }
  }
  return result;
}

}  // namespace meshloop
