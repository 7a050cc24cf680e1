#pragma once
// The part that runs in the child process: a file through assimp into parts.
#include <filesystem>
#include <vector>

#include "common/base/result.h"
#include "common/interchange/model_file.h"

namespace meshloop {

/// One part for each use of a mesh in the file's scene graph, transforms applied, vertices with the same position and
/// colour joined. May crash on a malformed file: see isolated_import.h.
[[nodiscard]] Result<std::vector<ImportedPart>> read_parts(const std::filesystem::path& file);

}  // namespace meshloop
