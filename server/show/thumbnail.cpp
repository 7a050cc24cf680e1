#include "server/show/thumbnail.h"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>

#include "server/show/picture.h"
#include "server/show/text.h"

namespace meshloop {
namespace {

// Around a region, as a share of its longer side.
constexpr double kSurroundings = 0.35;
constexpr int kLeastSurroundings_px = 12;
constexpr int kLineWidth_px = 2;

// What a region looks like from the colour camera.
struct Seen {
  Eigen::AlignedBox2i box;
  std::array<int, kLabels.size()> labels{};
};

std::map<RegionId, Seen> find_seen(const Image<std::uint32_t>& source, const Comparison& comparison,
                                   const RegionMap& regions, const std::vector<RegionId>& wanted) {
  std::map<RegionId, Seen> seen;
  for (int y = 0; y < source.height(); ++y) {
    for (int x = 0; x < source.width(); ++x) {
      const std::uint32_t from = source(x, y);
      const RegionId id = from == 0 ? 0 : regions.ids.data()[from - 1];
      if (id == 0 || std::find(wanted.begin(), wanted.end(), id) == wanted.end()) continue;
      Seen& region = seen[id];
      region.box.extend(Eigen::Vector2i{x, y});
      ++region.labels[static_cast<std::size_t>(comparison.labels.data()[from - 1])];
    }
  }
  return seen;
}

cv::Rect crop_of(const Eigen::AlignedBox2i& box, const ColorImage& color) {
  const Eigen::Vector2i size = box.sizes() + Eigen::Vector2i::Ones();
  const int margin = std::max(kLeastSurroundings_px, static_cast<int>(kSurroundings * size.maxCoeff()));
  return cv::Rect{box.min().x() - margin, box.min().y() - margin, size.x() + 2 * margin, size.y() + 2 * margin} &
         cv::Rect{0, 0, color.width(), color.height()};
}

cv::Mat mask_of(RegionId id, const cv::Rect& crop, const Image<std::uint32_t>& source, const RegionMap& regions) {
  cv::Mat mask{crop.size(), CV_8U, cv::Scalar{0}};
  for (int y = 0; y < crop.height; ++y) {
    for (int x = 0; x < crop.width; ++x) {
      const std::uint32_t from = source(crop.x + x, crop.y + y);
      if (from != 0 && regions.ids.data()[from - 1] == id) mask.at<std::uint8_t>(y, x) = 255;
    }
  }
  return mask;
}

Rgb8 line_color(const Seen& seen, Palette palette) {
  const auto most = std::max_element(seen.labels.begin(), seen.labels.end()) - seen.labels.begin();
  const LabelInfo& label = kLabels[static_cast<std::size_t>(most)];
  return palette == Palette::paper ? label.paper_color : label.safe_color;
}

ColorImage draw(cv::Mat color, cv::Mat mask, Rgb8 line) {
  const double scale = kThumbnail_px / static_cast<double>(std::max(color.cols, color.rows));
  const cv::Size size{std::clamp(cvRound(color.cols * scale), 1, kThumbnail_px),
                      std::clamp(cvRound(color.rows * scale), 1, kThumbnail_px)};
  ColorImage picture{size.width, size.height};
  cv::Mat target = show::wrap(picture);
  cv::resize(color, target, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  cv::resize(mask, mask, size, 0, 0, cv::INTER_NEAREST);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::drawContours(target, outlines, -1, show::scalar({255, 255, 255}), kLineWidth_px + 2, cv::LINE_AA);
  cv::drawContours(target, outlines, -1, show::scalar(line), kLineWidth_px, cv::LINE_AA);
  return picture;
}

}  // namespace

std::vector<RegionThumbnail> region_thumbnails(const Image<std::uint32_t>& source, const Comparison& comparison,
                                               const ColorImage& color, const RegionMap& regions,
                                               const std::vector<RegionId>& wanted, Palette palette) {
  const bool fits = source.width() == color.width() && source.height() == color.height() && !color.empty() &&
                    regions.ids.size() == comparison.labels.size();
  if (!fits || wanted.empty()) return {};
  ColorImage copy = color;  // OpenCV's view of an image is not const
  const cv::Mat whole = show::wrap(copy);
  std::vector<RegionThumbnail> thumbnails;
  for (const auto& [id, seen] : find_seen(source, comparison, regions, wanted)) {
    const cv::Rect crop = crop_of(seen.box, color);
    thumbnails.push_back({id, draw(whole(crop), mask_of(id, crop, source, regions), line_color(seen, palette))});
  }
  return thumbnails;
}

}  // namespace meshloop
