#include "server/adjust/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace meshloop::adjust {
namespace {

/// A corner that fitted lines put farther from the steps than so many times what is straight stays where they have it.
constexpr double kCornerMoves = 1.5;
constexpr std::size_t kFittedSteps = 6;
/// A line as ragged as noise is straightened further: what it is cut from takes the square of its corners.
constexpr std::size_t kMostCorners = 300;

using Corner = std::pair<int, int>;

/// One side of a pixel, with the pixel to its right in an image whose rows run downwards.
struct Side {
  Corner from;
  Corner to;
  Corner pixel;
};

/// Sides between a pixel of the mask and one outside.
std::multimap<Corner, Side> sides_of(const Image<std::uint8_t>& mask) {
  const auto is_in = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < mask.width() && y < mask.height() && mask(x, y) != 0;
  };
  std::multimap<Corner, Side> sides;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!is_in(x, y)) continue;
      const auto add = [&](Corner from, Corner to) { sides.emplace(from, Side{from, to, {x, y}}); };
      if (!is_in(x, y - 1)) add({x, y}, {x + 1, y});
      if (!is_in(x + 1, y)) add({x + 1, y}, {x + 1, y + 1});
      if (!is_in(x, y + 1)) add({x + 1, y + 1}, {x, y + 1});
      if (!is_in(x - 1, y)) add({x, y + 1}, {x, y});
    }
  }
  return sides;
}

/// The middles of the sides of one closed line; its sides are taken away.
std::vector<cv::Point2f> take_line(std::multimap<Corner, Side>& sides) {
  std::vector<cv::Point2f> middles;
  auto at = sides.begin();
  while (at != sides.end()) {
    const Side side = at->second;
    sides.erase(at);
    middles.emplace_back(static_cast<float>(side.from.first + side.to.first) / 2 - 0.5F,
                         static_cast<float>(side.from.second + side.to.second) / 2 - 0.5F);
    // Where two lines touch, the one that stays at the pixel goes on.
    const auto [first, last] = sides.equal_range(side.to);
    at = std::find_if(first, last, [&](const auto& next) { return next.second.pixel == side.pixel; });
    if (at == last) at = first == last ? sides.end() : first;
  }
  return middles;
}

/// A line through points, at equal weight but for strays.
cv::Vec4f fit(const std::vector<cv::Point2f>& middles, std::size_t first, std::size_t count) {
  std::vector<cv::Point2f> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(middles[(first + i) % middles.size()]);
  cv::Vec4f line;
  cv::fitLine(points, line, cv::DIST_HUBER, 0, 0.01, 0.01);
  return line;
}

/// Where two lines meet, unless they run nearly the same way.
bool meet(const cv::Vec4f& a, const cv::Vec4f& b, Eigen::Vector2d& corner) {
  constexpr double kSine = 0.3;
  const Eigen::Vector2d along_a{static_cast<double>(a[0]), static_cast<double>(a[1])};
  const Eigen::Vector2d along_b{static_cast<double>(b[0]), static_cast<double>(b[1])};
  const Eigen::Vector2d from_a{static_cast<double>(a[2]), static_cast<double>(a[3])};
  const Eigen::Vector2d from_b{static_cast<double>(b[2]), static_cast<double>(b[3])};
  const double sine = along_a.x() * along_b.y() - along_a.y() * along_b.x();
  if (std::abs(sine) < kSine) return false;
  const Eigen::Vector2d between = from_b - from_a;
  corner = from_a + along_a * ((between.x() * along_b.y() - between.y() * along_b.x()) / sine);
  return true;
}

Loop straightened(const std::vector<cv::Point2f>& middles, double straight_px) {
  std::vector<cv::Point2f> corners;
  for (double off_px = straight_px; corners.empty() || corners.size() > kMostCorners; off_px *= 1.5) {
    cv::approxPolyDP(middles, corners, off_px, true);
  }
  const std::size_t n = corners.size();
  std::vector<std::size_t> places;
  for (const auto& corner : corners) {
    places.push_back(static_cast<std::size_t>(std::find(middles.begin(), middles.end(), corner) - middles.begin()));
  }
  // The steps between two corners, without those right at the corners, which belong to both sides.
  std::vector<std::pair<bool, cv::Vec4f>> lines(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t steps = (places[(i + 1) % n] + middles.size() - places[i]) % middles.size();
    if (steps >= kFittedSteps) lines[i] = {true, fit(middles, places[i] + 2, steps - 3)};
  }
  Loop loop;
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [has_before, before] = lines[(i + n - 1) % n];
    const auto& [has_after, after] = lines[i];
    const Eigen::Vector2d stepped{static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)};
    Eigen::Vector2d corner = stepped;
    const bool is_better = has_before && has_after && meet(before, after, corner) &&
                           (corner - stepped).norm() <= kCornerMoves * straight_px;
    loop.push_back(is_better ? corner : stepped);
  }
  return loop;
}

}  // namespace

std::vector<Loop> outline_of(const Image<std::uint8_t>& mask, double smallest_px, double straight_px) {
  auto sides = sides_of(mask);
  std::vector<Loop> loops;
  while (!sides.empty()) {
    const auto middles = take_line(sides);
    if (middles.size() < 4 || std::abs(cv::contourArea(middles)) < smallest_px) continue;
    Loop loop = straightened(middles, straight_px);
    if (loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace meshloop::adjust
