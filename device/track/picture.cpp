#include "device/track/picture.h"

#include <opencv2/imgproc.hpp>

#include "device/track/local_contrast.h"

namespace meshloop {
namespace {

constexpr double kBlur_px = 1.0;

}  // namespace

Picture::Picture(const ColorImage& color)
    : grey{to_grey(color)}, contrast{local_contrast(grey, {}, {})}, smooth{grey.width(), grey.height()} {
  const cv::Mat sharp{grey.height(), grey.width(), CV_8UC1, grey.data()};
  cv::Mat blurred{smooth.height(), smooth.width(), CV_8UC1, smooth.data()};
  cv::GaussianBlur(sharp, blurred, {5, 5}, kBlur_px);
}

}  // namespace meshloop
