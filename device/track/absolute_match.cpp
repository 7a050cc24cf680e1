#include "device/track/absolute_match.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/features/klt.h"

namespace meshloop {
namespace {

constexpr int kPatchRadius_px = 6;
/// Corners keep this distance to the outline of the coloured surface.
constexpr int kOutlineMargin_px = 5;
constexpr double kFlat = 1e-3;

double value_between(const GreyImage& image, double x, double y) {
  const int left = static_cast<int>(std::floor(x));
  const int top = static_cast<int>(std::floor(y));
  const double right = x - left;
  const double down = y - top;
  const auto at = [&](int dx, int dy) { return static_cast<double>(image(left + dx, top + dy)); };
  return (1 - down) * ((1 - right) * at(0, 0) + right * at(1, 0)) + down * ((1 - right) * at(0, 1) + right * at(1, 1));
}

bool patch_inside(const GreyImage& image, const Eigen::Vector2d& pixel, int radius_px) {
  return pixel.x() >= radius_px && pixel.y() >= radius_px && pixel.x() < image.width() - 1 - radius_px &&
         pixel.y() < image.height() - 1 - radius_px;
}

struct Sums {
  double a = 0;
  double b = 0;
  double aa = 0;
  double bb = 0;
  double ab = 0;
};

}  // namespace

AbsoluteSearch wide_search() {
  AbsoluteSearch search;
  search.window_px = 25;
  search.pyramid_levels = 4;
  search.max_shift_px = 80;
  search.min_similarity = 0.5;
  return search;
}

double patch_similarity(const GreyImage& a, const Eigen::Vector2d& pixel_a, const GreyImage& b,
                        const Eigen::Vector2d& pixel_b, int radius_px) {
  if (!patch_inside(a, pixel_a, radius_px) || !patch_inside(b, pixel_b, radius_px)) return 0;
  Sums sums;
  for (int dy = -radius_px; dy <= radius_px; ++dy) {
    for (int dx = -radius_px; dx <= radius_px; ++dx) {
      const double va = value_between(a, pixel_a.x() + dx, pixel_a.y() + dy);
      const double vb = value_between(b, pixel_b.x() + dx, pixel_b.y() + dy);
      sums.a += va;
      sums.b += vb;
      sums.aa += va * va;
      sums.bb += vb * vb;
      sums.ab += va * vb;
    }
  }
  const double count = (2.0 * radius_px + 1) * (2.0 * radius_px + 1);
  const double spread_a = sums.aa - sums.a * sums.a / count;
  const double spread_b = sums.bb - sums.b * sums.b / count;
  if (spread_a < kFlat * count || spread_b < kFlat * count) return 0;
  return (sums.ab - sums.a * sums.b / count) / std::sqrt(spread_a * spread_b);
}

std::vector<AbsoluteMatch> match_view(const RenderedView& view, const GreyImage& contrast,
                                      const AbsoluteSearch& search) {
  if (view.contrast.empty()) return {};
  CornerOptions corner_options;
  corner_options.max_corners = search.max_corners;
  corner_options.min_distance_px = 9;
  const auto corners = find_corners(view.grey, corner_mask(view, kOutlineMargin_px), {}, corner_options);
  std::vector<AbsoluteMatch> matches;
  std::vector<Eigen::Vector2d> expected;
  for (const auto& corner : corners) {
    const auto point = world_point(view, corner);
    if (!point) continue;
    expected.push_back(corner);
    matches.push_back({*point, corner, corner, false});
  }
  FlowOptions flow;
  flow.window_px = search.window_px;
  flow.pyramid_levels = search.pyramid_levels;
  const auto tracked = track_points(view.contrast, contrast, expected, {}, flow);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!tracked[i].found) continue;
    matches[i].pixel = tracked[i].pixel;
    matches[i].found = (tracked[i].pixel - expected[i]).norm() <= search.max_shift_px &&
                       patch_similarity(view.contrast, expected[i], contrast, tracked[i].pixel, kPatchRadius_px) >=
                           search.min_similarity;
  }
  return matches;
}

std::vector<PointObservation> observations_of(const std::vector<AbsoluteMatch>& matches, double sigma_px) {
  std::vector<PointObservation> observations;
  for (const auto& match : matches) {
    if (match.found) observations.push_back({match.p_world, match.pixel, sigma_px});
  }
  return observations;
}

}  // namespace meshloop
