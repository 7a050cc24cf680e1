#include "server/show/text.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace meshloop::show {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontScale = 0.45;

}  // namespace

cv::Mat wrap(ColorImage& image) {
  return {image.height(), image.width(), CV_8UC3, image.data()};
}

cv::Scalar scalar(Rgb8 color) {
  return {double(color.r), double(color.g), double(color.b)};
}

int Pen::px(double length) const {
  return static_cast<int>(std::lround(length * scale_));
}

cv::Size Pen::size_of(const std::string& text) const {
  int baseline = 0;
  return cv::getTextSize(text, kFont, kFontScale * scale_, 1, &baseline);
}

void Pen::write(cv::Mat& image, const std::string& text, cv::Point left_bottom, Rgb8 color) const {
  const int thickness = scale_ >= 1.6 ? 2 : 1;
  cv::putText(image, text, left_bottom, kFont, kFontScale * scale_, scalar(color), thickness, cv::LINE_AA);
}

}  // namespace meshloop::show
