#pragma once
// The files that an earlier run of `detect` left.
#include <cstddef>
#include <filesystem>

#include "common/base/result.h"

namespace meshloop {

/// Removes the files in a folder whose names `detect` gives, and says how many. Folders, and all else that lies there,
/// stay. They would be taken for results of the run that follows: frames of another recording, regions of other
/// numbers.
[[nodiscard]] Result<std::size_t> remove_files_of_detect(const std::filesystem::path& folder);

}  // namespace meshloop
