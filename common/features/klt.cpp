#include "common/features/klt.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace meshloop {
namespace {

constexpr int kBlock = 3;

struct Candidate {
  float response;
  cv::Point pixel;
};

// For reading only: OpenCV has no matrix of constant pixels.
cv::Mat view_for_reading(const GreyImage& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
}

// Refuses pixels that are nearer than a distance to one that it has; cells keep the search local.
class Spacing {
 public:
  Spacing(int width, int height, double distance)
      : distance_{std::max(distance, 1.0)},
        columns_{static_cast<int>(width / distance_) + 1},
        rows_{static_cast<int>(height / distance_) + 1},
        cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  void add(const Eigen::Vector2d& pixel) { cell(column_of(pixel), row_of(pixel)).push_back(pixel); }

  [[nodiscard]] bool has_room(const Eigen::Vector2d& pixel) {
    const int column = column_of(pixel);
    const int row = row_of(pixel);
    for (int y = std::max(0, row - 1); y <= std::min(rows_ - 1, row + 1); ++y) {
      for (int x = std::max(0, column - 1); x <= std::min(columns_ - 1, column + 1); ++x) {
        for (const Eigen::Vector2d& other : cell(x, y)) {
          if ((other - pixel).squaredNorm() < distance_ * distance_) return false;
        }
      }
    }
    return true;
  }

 private:
  [[nodiscard]] int column_of(const Eigen::Vector2d& p) const {
    return static_cast<int>(std::clamp(p.x() / distance_, 0.0, columns_ - 1.0));
  }
  [[nodiscard]] int row_of(const Eigen::Vector2d& p) const {
    return static_cast<int>(std::clamp(p.y() / distance_, 0.0, rows_ - 1.0));
  }
  [[nodiscard]] std::vector<Eigen::Vector2d>& cell(int x, int y) {
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)];
  }

  double distance_;
  int columns_;
  int rows_;
  std::vector<std::vector<Eigen::Vector2d>> cells_;
};

// Local maxima of the smaller eigenvalue above a share of the strongest, strongest first.
std::vector<Candidate> candidates_of(const GreyImage& image, const GreyImage& mask, double quality) {
  cv::Mat response;
  cv::cornerMinEigenVal(view_for_reading(image), response, kBlock);
  double strongest = 0;
  const bool masked = mask.width() == image.width() && mask.height() == image.height();
  cv::minMaxLoc(response, nullptr, &strongest, nullptr, nullptr, masked ? view_for_reading(mask) : cv::Mat{});
  const auto least = static_cast<float>(std::max(strongest * quality, 1e-9));
  cv::Mat peaks;
  cv::dilate(response, peaks, cv::Mat{});
  std::vector<Candidate> found;
  for (int y = kBlock; y < image.height() - kBlock; ++y) {
    const auto* values = response.ptr<float>(y);
    const auto* highest = peaks.ptr<float>(y);
    for (int x = kBlock; x < image.width() - kBlock; ++x) {
      if (values[x] < least || values[x] < highest[x] || (masked && mask(x, y) == 0)) continue;
      found.push_back({values[x], {x, y}});
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Candidate& a, const Candidate& b) { return a.response > b.response; });
  return found;
}

std::vector<cv::Point2f> to_opencv(const std::vector<Eigen::Vector2d>& points) {
  std::vector<cv::Point2f> converted;
  converted.reserve(points.size());
  for (const Eigen::Vector2d& p : points) converted.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  return converted;
}

struct Flow {
  std::vector<cv::Point2f> points;
  std::vector<std::uint8_t> found;
};

Flow flow(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to, const std::vector<cv::Point2f>& points,
          const std::vector<cv::Point2f>& starts, const FlowOptions& options) {
  Flow result{starts, {}};
  const cv::TermCriteria stop{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.005};
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(from, to, points, result.points, result.found, error,
                           cv::Size{options.window_px, options.window_px}, options.pyramid_levels - 1, stop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, 1e-4);
  return result;
}

bool inside(const cv::Point2f& p, const GreyImage& image) {
  return p.x >= 0 && p.y >= 0 && p.x <= static_cast<float>(image.width() - 1) &&
         p.y <= static_cast<float>(image.height() - 1);
}

std::vector<cv::Mat> pyramid_of(const GreyImage& image, const FlowOptions& options) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(view_for_reading(image), pyramid, cv::Size{options.window_px, options.window_px},
                              options.pyramid_levels - 1);
  return pyramid;
}

double width_ratio(int width) {
  return std::max(width, 1) / 640.0;
}

double length_scale(int width) {
  return std::sqrt(std::min(1.0, width_ratio(width)));
}

}  // namespace

CornerOptions corner_options_for(int width) {
  CornerOptions options;
  options.min_distance_px *= length_scale(width);
  return options;
}

FlowOptions flow_options_for(int width) {
  FlowOptions options;
  options.window_px = 2 * static_cast<int>(std::lround((options.window_px * length_scale(width) - 1) / 2)) + 1;
  // Each level doubles what a point may move.
  const double levels = options.pyramid_levels + std::log2(width_ratio(width) / length_scale(width));
  options.pyramid_levels = std::max(2, static_cast<int>(std::lround(levels)));
  return options;
}

std::vector<Eigen::Vector2d> find_corners(const GreyImage& image, const GreyImage& mask,
                                          const std::vector<Eigen::Vector2d>& taken, const CornerOptions& options) {
  std::vector<Eigen::Vector2d> corners;
  if (image.width() <= 2 * kBlock || image.height() <= 2 * kBlock || options.max_corners <= 0) return corners;
  const int grid = std::max(1, options.grid);
  Spacing spacing{image.width(), image.height(), options.min_distance_px};
  std::vector<int> in_cell(static_cast<std::size_t>(grid) * static_cast<std::size_t>(grid));
  const auto cell_of = [&](const Eigen::Vector2d& p) {
    const int x = std::clamp(static_cast<int>(p.x() * grid / image.width()), 0, grid - 1);
    const int y = std::clamp(static_cast<int>(p.y() * grid / image.height()), 0, grid - 1);
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid) + static_cast<std::size_t>(x);
  };
  for (const Eigen::Vector2d& p : taken) {
    if (!p.allFinite()) continue;
    spacing.add(p);
    ++in_cell[cell_of(p)];
  }
  const int quota = (options.max_corners + static_cast<int>(taken.size()) + grid * grid - 1) / (grid * grid);
  for (const Candidate& candidate : candidates_of(image, mask, options.quality)) {
    const Eigen::Vector2d p{candidate.pixel.x, candidate.pixel.y};
    if (in_cell[cell_of(p)] >= quota || !spacing.has_room(p)) continue;
    spacing.add(p);
    ++in_cell[cell_of(p)];
    corners.push_back(p);
    if (static_cast<int>(corners.size()) == options.max_corners) break;
  }
  return corners;
}

std::vector<TrackedPoint> track_points(const GreyImage& from, const GreyImage& to,
                                       const std::vector<Eigen::Vector2d>& points,
                                       const std::vector<Eigen::Vector2d>& guesses, const FlowOptions& options) {
  std::vector<TrackedPoint> tracked(points.size());
  const bool usable = !from.empty() && from.width() == to.width() && from.height() == to.height() &&
                      (guesses.empty() || guesses.size() == points.size()) && options.window_px > 2 &&
                      options.pyramid_levels > 0;
  if (points.empty() || !usable) return tracked;
  const std::vector<cv::Mat> from_pyramid = pyramid_of(from, options);
  const std::vector<cv::Mat> to_pyramid = pyramid_of(to, options);
  const std::vector<cv::Point2f> origins = to_opencv(points);
  const std::vector<cv::Point2f> starts = guesses.empty() ? origins : to_opencv(guesses);
  const Flow forward = flow(from_pyramid, to_pyramid, origins, starts, options);
  // The way back starts as far off as the way there did: started at the origin, it would agree too easily.
  std::vector<cv::Point2f> returns(origins.size());
  for (std::size_t i = 0; i < origins.size(); ++i) returns[i] = forward.points[i] + origins[i] - starts[i];
  const Flow back = flow(to_pyramid, from_pyramid, forward.points, returns, options);
  for (std::size_t i = 0; i < points.size(); ++i) {
    tracked[i].pixel = {forward.points[i].x, forward.points[i].y};
    const cv::Point2f gap = back.points[i] - origins[i];
    const double round_trip = std::hypot(gap.x, gap.y);
    tracked[i].found = forward.found[i] != 0 && back.found[i] != 0 && inside(forward.points[i], to) &&
                       round_trip <= options.max_round_trip_px;
  }
  return tracked;
}

}  // namespace meshloop
