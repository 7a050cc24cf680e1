#pragma once
#include <opencv2/core.hpp>
#include <string>

#include "common/image/image.h"

namespace meshloop::show {

/// OpenCV's view of our pixels, in our order of channels.
[[nodiscard]] cv::Mat wrap(ColorImage& image);
[[nodiscard]] cv::Scalar scalar(Rgb8 color);

/// One size of text. `scale` 1 has capitals of about 10 pixels.
class Pen {
 public:
  explicit Pen(double scale) : scale_{scale} {}
  [[nodiscard]] cv::Size size_of(const std::string& text) const;
  /// Anti-aliased; `left_bottom` is where the first letter stands.
  void write(cv::Mat& image, const std::string& text, cv::Point left_bottom, Rgb8 color) const;
  /// A length that goes with the size of the text.
  [[nodiscard]] int px(double length) const;

 private:
  double scale_;
};

}  // namespace meshloop::show
