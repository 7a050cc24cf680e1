#pragma once
#include <string_view>

#include "common/interchange/read_file.h"

namespace meshloop {

/// True for a binary STL: its size is what its count of triangles says.
[[nodiscard]] bool is_binary_stl(std::string_view content);

/// The triangles of a binary STL, in the winding in which they stand; each has vertices of its own. Empty when the
/// content is something else. Survives any bytes.
[[nodiscard]] Submesh parse_binary_stl(std::string_view content);

/// A FormatReader, for both kinds.
[[nodiscard]] Result<ReadParts> read_stl(const std::filesystem::path& file, const Progress& progress);

}  // namespace meshloop
