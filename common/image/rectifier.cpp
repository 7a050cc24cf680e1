#include "common/image/rectifier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace meshloop {
namespace {

std::vector<Eigen::Vector2f> source_map(const Camera& camera) {
  std::vector<Eigen::Vector2f> map;
  map.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  const double limit = camera.lens_limit();
  const Eigen::Vector2f nowhere = Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const bool seen = camera.back_project(x, y, 1).head<2>().norm() <= limit;
      map.push_back(seen ? camera.distort(Eigen::Vector2d(x, y)).cast<float>() : nowhere);
    }
  }
  return map;
}

std::uint8_t mix(const std::array<std::uint8_t, 4>& corners, float ax, float ay) {
  const float top = static_cast<float>(corners[0]) * (1 - ax) + static_cast<float>(corners[1]) * ax;
  const float bottom = static_cast<float>(corners[2]) * (1 - ax) + static_cast<float>(corners[3]) * ax;
  return static_cast<std::uint8_t>(top * (1 - ay) + bottom * ay + 0.5f);
}

// At the rim the outermost pixels continue for half a pixel.
Rgb8 bilinear(const ColorImage& image, const Eigen::Vector2f& at) {
  const float u = std::clamp(at.x(), 0.0f, static_cast<float>(image.width() - 1));
  const float v = std::clamp(at.y(), 0.0f, static_cast<float>(image.height() - 1));
  const int x0 = static_cast<int>(u);
  const int y0 = static_cast<int>(v);
  const int x1 = std::min(x0 + 1, image.width() - 1);
  const int y1 = std::min(y0 + 1, image.height() - 1);
  const std::array<Rgb8, 4> p{image(x0, y0), image(x1, y0), image(x0, y1), image(x1, y1)};
  const float ax = u - static_cast<float>(x0);
  const float ay = v - static_cast<float>(y0);
  return {mix({p[0].r, p[1].r, p[2].r, p[3].r}, ax, ay), mix({p[0].g, p[1].g, p[2].g, p[3].g}, ax, ay),
          mix({p[0].b, p[1].b, p[2].b, p[3].b}, ax, ay)};
}

float nearest(const DepthImage& image, const Eigen::Vector2f& at) {
  const int x = std::clamp(static_cast<int>(std::lround(at.x())), 0, image.width() - 1);
  const int y = std::clamp(static_cast<int>(std::lround(at.y())), 0, image.height() - 1);
  return image(x, y);
}

template <class T, class Sample>
Image<T> resample(const Camera& camera, const std::vector<Eigen::Vector2f>& source, const Image<T>& image,
                  Sample sample) {
  Image<T> result{camera.width, camera.height};
  if (image.width() != camera.width || image.height() != camera.height) return result;
  std::transform(source.begin(), source.end(), result.pixels().begin(), [&](const Eigen::Vector2f& at) {
    return camera.contains(at.cast<double>()) ? sample(image, at) : T{};
  });
  return result;
}

}  // namespace

Rectifier::Rectifier(const Camera& camera)
    : camera_{camera},
      identity_{!camera.has_distortion()},
      source_{identity_ ? std::vector<Eigen::Vector2f>{} : source_map(camera)} {}

ColorImage Rectifier::rectify(const ColorImage& image) const {
  return identity_ ? image : resample(camera_, source_, image, bilinear);
}

DepthImage Rectifier::rectify(const DepthImage& image) const {
  return identity_ ? image : resample(camera_, source_, image, nearest);
}

}  // namespace meshloop
