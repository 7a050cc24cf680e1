#pragma once
#include <cstddef>

namespace meshloop {

/// Largest picture that is read, in pixels a side.
inline constexpr int kLargestSide = 8192;
/// Largest image file that is read: four bytes for each pixel of the largest picture, and a half again.
inline constexpr std::size_t kLargestImageFile = 384u << 20;

}  // namespace meshloop
