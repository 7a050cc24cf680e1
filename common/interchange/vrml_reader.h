#pragma once
#include <string_view>

#include "common/interchange/read_file.h"
#include "common/interchange/scene_nodes.h"

namespace meshloop {

/// The nodes of a VRML 97 text (ISO/IEC 14772-1), with DEF and USE resolved. Routes and scripts are passed over; PROTO
/// is refused. Survives any bytes.
[[nodiscard]] Result<WebNodes> parse_vrml(std::string_view text);

/// A FormatReader.
[[nodiscard]] Result<ReadParts> read_vrml(const std::filesystem::path& file, const Progress& progress);

}  // namespace meshloop
