#include "server/show/picture.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "server/show/legend.h"
#include "server/show/text.h"

namespace meshloop::show {
namespace {

constexpr Rgb8 kFrame{255, 255, 255};
constexpr Rgb8 kShadow{0, 0, 0};

// Whole pixels, so that none is smeared.
void copy_enlarged(const ColorImage& picture, int factor, ColorImage& target) {
  for (int y = 0; y < picture.height() * factor; ++y) {
    const Rgb8* from = picture.data() + static_cast<std::ptrdiff_t>(y / factor) * picture.width();
    Rgb8* to = target.data() + static_cast<std::ptrdiff_t>(y) * target.width();
    if (factor == 1) {
      std::copy(from, from + picture.width(), to);
      continue;
    }
    for (int x = 0; x < picture.width(); ++x) to = std::fill_n(to, factor, from[x]);
  }
}

// Places for the text, best first; the first that is free and inside the picture is taken.
cv::Rect place_text(const cv::Rect& box, cv::Size size, cv::Size picture, const std::vector<cv::Rect>& taken) {
  const cv::Rect inside{0, 0, picture.width, picture.height};
  const int x = std::clamp(box.x, 0, std::max(0, picture.width - size.width));
  std::vector<cv::Rect> places{{{x, box.y - size.height - 1}, size}, {{x, box.y + box.height + 1}, size}};
  for (int k = 0; k < 12; ++k) places.push_back({{x, std::max(box.y, 0) + k * size.height + 2}, size});
  for (const auto& place : places) {
    const bool free = std::none_of(taken.begin(), taken.end(), [&](const auto& t) { return (t & place).area() > 0; });
    if (free && (place & inside) == place) return place;
  }
  return places[2] & inside;
}

void draw_marks(cv::Mat image, const std::vector<OverlayFrame>& marks, int factor) {
  const Pen pen{std::clamp(image.cols / 800.0, 1.0, 2.0)};
  std::vector<cv::Rect> taken;
  for (const auto& mark : marks) {
    const cv::Point low{mark.box.min().x() * factor - 2, mark.box.min().y() * factor - 2};
    const cv::Point high{(mark.box.max().x() + 1) * factor + 2, (mark.box.max().y() + 1) * factor + 2};
    const cv::Rect box{low, high};
    cv::rectangle(image, {box.x - 1, box.y - 1, box.width + 2, box.height + 2}, scalar(kShadow), 1);
    cv::rectangle(image, box, scalar(kFrame), 1);
    const cv::Size text = pen.size_of(mark.text);
    const cv::Size label{text.width + pen.px(8), text.height + pen.px(8)};
    const cv::Rect place = place_text(box, label, image.size(), taken);
    if (place.empty()) continue;
    cv::Mat below = image(place);
    below.convertTo(below, -1, 0.25);
    pen.write(image, mark.text, {place.x + pen.px(4), place.y + place.height - pen.px(4)}, kFrame);
    taken.push_back(place);
  }
}

}  // namespace

ColorImage finish(const ColorImage& picture, const std::vector<OverlayFrame>& marks,
                  const std::array<bool, kLabels.size()>& shown, const OverlayOptions& options) {
  if (picture.empty()) return {};
  const bool enlarge = options.legend && picture.width() < kNarrowest;
  const int factor = enlarge ? (kNarrowest + picture.width() - 1) / picture.width() : 1;
  const int width = picture.width() * factor;
  const ColorImage legend = options.legend ? draw_legend(width, shown, options) : ColorImage{};
  ColorImage whole{width, picture.height() * factor + legend.height()};
  copy_enlarged(picture, factor, whole);
  std::copy(legend.pixels().begin(), legend.pixels().end(), whole.pixels().end() - std::ptrdiff_t(legend.size()));
  draw_marks(wrap(whole).rowRange(0, picture.height() * factor), marks, factor);
  return whole;
}

}  // namespace meshloop::show
