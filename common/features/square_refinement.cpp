#include "common/features/square_refinement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "common/base/median.h"

namespace meshloop {
namespace {

using Line = Eigen::Hyperplane<double, 2>;

constexpr int kRounds = 3;
constexpr double kProfileStep = 0.5;
constexpr double kLongestReachPx = 3;
// Grey levels from the dark side of an edge to the bright one.
constexpr double kLeastContrast = 15;
constexpr int kLeastPoints = 5;
constexpr double kFurthestMovePx = 4;

std::optional<double> grey_at(const GreyImage& image, const Eigen::Vector2d& p) {
  if (!(p.x() >= 0 && p.y() >= 0 && p.x() < image.width() - 1 && p.y() < image.height() - 1)) return std::nullopt;
  const int x = static_cast<int>(p.x());
  const int y = static_cast<int>(p.y());
  const double s = p.x() - x;
  const double t = p.y() - y;
  return (1 - t) * ((1 - s) * image(x, y) + s * image(x + 1, y)) +
         t * ((1 - s) * image(x, y + 1) + s * image(x + 1, y + 1));
}

// How far from p along the outward normal the grey rises, as the centroid of the rise.
std::optional<double> edge_offset(const GreyImage& image, const Eigen::Vector2d& p, const Eigen::Vector2d& outward,
                                  double reach) {
  const int steps = static_cast<int>(reach / kProfileStep);
  auto before = grey_at(image, p - (steps * kProfileStep) * outward);
  double rise = 0;
  double moment = 0;
  for (int k = -steps; k < steps; ++k) {
    const auto after = grey_at(image, p + ((k + 1) * kProfileStep) * outward);
    if (!before || !after) return std::nullopt;
    const double slope = std::max(0.0, *after - *before);
    // Squared: noise on the flanks, which only ever adds where it rises, weighs little.
    rise += slope * slope;
    moment += slope * slope * (k + 0.5) * kProfileStep;
    before = after;
  }
  const auto inner = grey_at(image, p - reach * outward);
  const auto outer = grey_at(image, p + reach * outward);
  if (!inner || !outer || *outer - *inner < kLeastContrast || rise <= 0) return std::nullopt;
  return moment / rise;
}

Line fit_line(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d d = p - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  return Line{Eigen::Vector2d{-std::sin(angle), std::cos(angle)}, mean};
}

// The line through most of the points: the half that fits worse by far is left out once.
Line fit_line_robustly(std::vector<Eigen::Vector2d> points) {
  const Line first = fit_line(points);
  std::vector<double> distances;
  for (const Eigen::Vector2d& p : points) distances.push_back(first.absDistance(p));
  const double limit = 3 * median(std::move(distances)) + 0.02;
  std::erase_if(points, [&](const Eigen::Vector2d& p) { return first.absDistance(p) > limit; });
  return fit_line(points);
}

std::optional<Line> side_between(const GreyImage& image, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                 double reach) {
  const Eigen::Vector2d along = to - from;
  const double length = along.norm();
  // In an image (y down) the outside of a clockwise square lies to the left of its sides.
  const Eigen::Vector2d outward = Eigen::Vector2d{along.y(), -along.x()} / length;
  const double margin = std::clamp((reach + 1) / length, 0.1, 0.3);
  const int count = std::clamp(static_cast<int>(length * (1 - 2 * margin)), kLeastPoints, 60);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d p = from + (margin + (1 - 2 * margin) * (i + 0.5) / count) * along;
    if (const auto offset = edge_offset(image, p, outward, reach)) points.push_back(p + *offset * outward);
  }
  if (static_cast<int>(points.size()) < std::max(kLeastPoints, count / 2)) return std::nullopt;
  return fit_line_robustly(std::move(points));
}

std::optional<std::array<Eigen::Vector2d, 4>> refine_once(const GreyImage& image, int cells,
                                                          const std::array<Eigen::Vector2d, 4>& pixels) {
  std::array<std::optional<Line>, 4> sides;
  for (std::size_t i = 0; i < 4; ++i) {
    const double cell_px = (pixels[(i + 1) % 4] - pixels[i]).norm() / cells;
    const double reach = std::min(kLongestReachPx, 0.75 * cell_px);
    if (reach < 2 * kProfileStep) return std::nullopt;
    sides[i] = side_between(image, pixels[i], pixels[(i + 1) % 4], reach);
    if (!sides[i]) return std::nullopt;
  }
  std::array<Eigen::Vector2d, 4> refined;
  for (std::size_t i = 0; i < 4; ++i) refined[i] = sides[(i + 3) % 4]->intersection(*sides[i]);
  return refined;
}

}  // namespace

bool refine_square(const GreyImage& image, int cells, std::array<Eigen::Vector2d, 4>& pixels) {
  std::array<Eigen::Vector2d, 4> current = pixels;
  for (int round = 0; round < kRounds; ++round) {
    const auto refined = refine_once(image, cells, current);
    if (!refined) return false;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!((*refined)[i] - pixels[i]).allFinite() || ((*refined)[i] - pixels[i]).norm() > kFurthestMovePx)
        return false;
    }
    current = *refined;
  }
  pixels = current;
  return true;
}

}  // namespace meshloop
