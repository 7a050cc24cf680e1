#pragma once
#include <filesystem>

#include "common/base/result.h"
#include "common/interchange/model_file.h"

namespace meshloop {

/// True for files of shapes (common/implicit/shape_file.h), which are read here and not in a child process.
[[nodiscard]] bool is_shape_file(const std::filesystem::path& file);

/// One node a shape, with its stand-in of triangles.
[[nodiscard]] Result<ImportedModel> import_shapes(const std::filesystem::path& file, const ImportOptions& options);

}  // namespace meshloop
