#pragma once
// PLY: text, binary of both byte orders, any numeric types.
#include <string_view>

#include "common/interchange/read_file.h"

namespace meshloop {

/// One part, without a name. Read are the element `vertex` (x, y, z; red, green, blue as bytes, 16-bit numbers or
/// floats up to 1) and the lists `vertex_indices` or `vertex_index` of the elements `face` (polygons) and `tristrips`
/// (strips that -1 separates); everything else is passed over. Survives any bytes.
[[nodiscard]] Result<Submesh> parse_ply(std::string_view content, const Progress& progress);

/// A FormatReader.
[[nodiscard]] Result<ReadParts> read_ply(const std::filesystem::path& file, const Progress& progress);

}  // namespace meshloop
