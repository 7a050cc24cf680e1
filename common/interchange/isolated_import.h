#pragma once
#include <filesystem>
#include <vector>

#include "common/base/result.h"
#include "common/interchange/model_file.h"

namespace meshloop {

/// read_parts in a child process with limits on processor time and memory, without a core file. A crash there is an
/// error here. The parts are not validated.
[[nodiscard]] Result<std::vector<ImportedPart>> read_parts_isolated(const std::filesystem::path& file,
                                                                    unsigned max_seconds);

/// The mechanism, for any reader: what `read` returns in the child process is returned here.
[[nodiscard]] Result<std::vector<ImportedPart>> run_isolated(
    const std::filesystem::path& file, unsigned max_seconds,
    Result<std::vector<ImportedPart>> (*read)(const std::filesystem::path&));

}  // namespace meshloop
