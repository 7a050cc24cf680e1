#include "common/image/image.h"

#include <algorithm>

namespace meshloop {

GreyImage to_grey(const ColorImage& color) {
  GreyImage grey{color.width(), color.height()};
  // 0.299, 0.587, 0.114 in 16-bit fixed point
  std::transform(color.pixels().begin(), color.pixels().end(), grey.pixels().begin(), [](Rgb8 p) {
    return static_cast<std::uint8_t>((19595u * p.r + 38470u * p.g + 7471u * p.b + 32768u) >> 16);
  });
  return grey;
}

ColorImage to_color(const GreyImage& grey) {
  ColorImage color{grey.width(), grey.height()};
  std::transform(grey.pixels().begin(), grey.pixels().end(), color.pixels().begin(), [](std::uint8_t v) {
    return Rgb8{v, v, v};
  });
  return color;
}

}  // namespace meshloop
