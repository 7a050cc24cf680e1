#pragma once
// Colours are stored as (r - g, g, b - g) around the middle, modulo 256: reversible, and of less entropy than RGB,
// since brightness changes more from vertex to vertex than hue.
#include <array>
#include <cstdint>

#include "common/image/image.h"

namespace meshloop {

using CodedColor = std::array<std::uint8_t, 3>;

[[nodiscard]] constexpr CodedColor to_coded(const Rgb8& color) {
  return {static_cast<std::uint8_t>(color.r - color.g + 128), color.g,
          static_cast<std::uint8_t>(color.b - color.g + 128)};
}

[[nodiscard]] constexpr Rgb8 from_coded(const CodedColor& coded) {
  return {static_cast<std::uint8_t>(coded[0] + coded[1] - 128), coded[1],
          static_cast<std::uint8_t>(coded[2] + coded[1] - 128)};
}

}  // namespace meshloop
