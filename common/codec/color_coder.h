#pragma once
// The colours of a mesh in the order of its coded vertices: each component's delta to the vertex before, learned
// beside the deltas that are known already.
#include <cstddef>
#include <span>
#include <vector>

#include "common/codec/bit_coder.h"
#include "common/image/image.h"

namespace meshloop {

/// kCoarseColorStep where all colours are in such steps, as a snapshot's are, else 1.
[[nodiscard]] int color_step(std::span<const Rgb8> colors);

/// In steps of `step`, which must be that of `color_step` or 1.
void encode_colors(BitEncoder& out, std::span<const Rgb8> colors, int step);
/// Whatever the bits are, it gives so many colours.
[[nodiscard]] std::vector<Rgb8> decode_colors(BitDecoder& in, std::size_t count, int step);

}  // namespace meshloop
