#pragma once
// sRGB bytes and linear light (IEC 61966-2-1). glTF states vertex and material colours as linear light.
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace meshloop {

[[nodiscard]] inline std::uint8_t to_byte(float value) {
  // The comparison is written so that NaN becomes 0.
  return value > 0 ? static_cast<std::uint8_t>(std::lround(std::min(value, 1.0f) * 255)) : std::uint8_t{0};
}

[[nodiscard]] inline float linear_from_srgb(std::uint8_t byte) {
  const float value = static_cast<float>(byte) / 255;
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

[[nodiscard]] inline std::uint8_t srgb_from_linear(float value) {
  return to_byte(value <= 0.0031308f ? value * 12.92f : 1.055f * std::pow(value, 1 / 2.4f) - 0.055f);
}

}  // namespace meshloop
