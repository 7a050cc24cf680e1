#pragma once
#include <cstddef>
#include <filesystem>
#include <span>

#include "common/base/result.h"

namespace meshloop {

/// Writes a temporary file beside the target, brings it to the disk, and renames it: under the target's name stands
/// either what stood there before or all of the new bytes. A failure leaves no temporary file.
[[nodiscard]] Status replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace meshloop
