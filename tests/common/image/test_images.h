#pragma once
#include <random>

#include "common/image/image.h"

namespace meshloop {

/// A gradient with noise: neither constant nor incompressible.
inline ColorImage noisy_gradient(int width, int height) {
  std::mt19937 random{7};
  ColorImage image{width, height};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto noise = static_cast<int>(random() % 8);
      image(x, y) = {static_cast<std::uint8_t>((x + noise) % 256), static_cast<std::uint8_t>((y + noise) % 256),
                     static_cast<std::uint8_t>((x + y) / 2 % 256)};
    }
  }
  return image;
}

}  // namespace meshloop
