#pragma once
#include "common/interchange/read_file.h"

namespace meshloop {

/// A FormatReader for glTF and GLB, with KHR_draco_mesh_compression too.
[[nodiscard]] Result<ReadParts> read_gltf(const std::filesystem::path& file, const Progress& progress);

}  // namespace meshloop
