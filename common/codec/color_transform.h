#pragma once
// Colours are stored as (r - g, g, b - g) around the middle, modulo 256: reversible, and of less entropy than RGB,
// since brightness changes more from vertex to vertex than hue. Where every colour of a submesh is a multiple of
// kCoarseColorStep, the quotients are stored instead.
#include <array>
#include <cstdint>

#include "common/image/image.h"
#include "common/mesh/lattice.h"

namespace meshloop {

using CodedColor = std::array<std::uint8_t, 3>;

[[nodiscard]] constexpr CodedColor to_coded(const Rgb8& color, int step) {
  const int g = color.g / step;
  return {static_cast<std::uint8_t>(color.r / step - g + 128), static_cast<std::uint8_t>(g),
          static_cast<std::uint8_t>(color.b / step - g + 128)};
}

/// Modulo 256, whatever the bytes are.
[[nodiscard]] constexpr Rgb8 from_coded(const CodedColor& coded, int step) {
  return {static_cast<std::uint8_t>((coded[0] + coded[1] - 128) * step), static_cast<std::uint8_t>(coded[1] * step),
          static_cast<std::uint8_t>((coded[2] + coded[1] - 128) * step)};
}

}  // namespace meshloop
