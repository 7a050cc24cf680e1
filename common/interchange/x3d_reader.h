#pragma once
#include <string_view>

#include "common/interchange/read_file.h"
#include "common/interchange/scene_nodes.h"

namespace meshloop {

struct X3dScene {
  WebNodes nodes;
  /// From the header's `unit` statement; 1 without one.
  double unit_m = 1;
};

/// The nodes of an X3D file in its XML encoding (ISO/IEC 19776-1), with DEF and USE resolved. Routes and scripts are
/// passed over; prototypes are refused. Survives any bytes.
[[nodiscard]] Result<X3dScene> parse_x3d(std::string_view text);

/// A FormatReader.
[[nodiscard]] Result<ReadParts> read_x3d(const std::filesystem::path& file, const Progress& progress);

}  // namespace meshloop
