#include "device/track/local_contrast.h"

#include <opencv2/imgproc.hpp>

namespace meshloop {
namespace {

constexpr double kMiddle = 128;
/// Grey levels of the result for one standard deviation.
constexpr double kGain = 42;
constexpr double kSmoothing_px = 0.8;

cv::Mat as_float(const GreyImage& image) {
  const cv::Mat bytes{image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
  cv::Mat values;
  bytes.convertTo(values, CV_32F);
  return values;
}

cv::Mat mean_around(const cv::Mat& values, int window_px) {
  cv::Mat mean;
  cv::boxFilter(values, mean, CV_32F, {window_px, window_px}, {-1, -1}, true, cv::BORDER_REPLICATE);
  return mean;
}

/// 1 where the mask is set; empty for no mask.
cv::Mat weights_of(const GreyImage& mask) {
  if (mask.empty()) return {};
  const cv::Mat weights = as_float(mask);
  return cv::min(weights, 1.0f);
}

}  // namespace

GreyImage local_contrast(const GreyImage& grey, const GreyImage& mask, const LocalContrastOptions& options) {
  if (grey.empty()) return {};
  cv::Mat values = as_float(grey);
  const cv::Mat weights = weights_of(mask);
  if (!weights.empty()) values = values.mul(weights);
  cv::Mat mean = mean_around(values, options.window_px);
  cv::Mat square = mean_around(values.mul(values), options.window_px);
  if (!weights.empty()) {
    const cv::Mat share = cv::max(mean_around(weights, options.window_px), 1e-3f);
    mean = mean / share;
    square = square / share;
  }
  cv::Mat spread;
  cv::sqrt(cv::max(square - mean.mul(mean), 0.0f), spread);
  cv::Mat normal = (values - mean) / (spread + options.floor);
  if (!weights.empty()) normal = normal.mul(weights);
  cv::GaussianBlur(normal, normal, {3, 3}, kSmoothing_px, 0, cv::BORDER_REPLICATE);

  GreyImage result{grey.width(), grey.height()};
  cv::Mat bytes{result.height(), result.width(), CV_8UC1, result.data()};
  normal.convertTo(bytes, CV_8U, kGain, kMiddle);
  return result;
}

}  // namespace meshloop
