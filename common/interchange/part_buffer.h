#pragma once
// Parts as flat bytes, for the way from the importing child process to its parent. The reader trusts nothing in them.
#include <cstddef>
#include <span>
#include <vector>

#include "common/interchange/model_file.h"

namespace meshloop {

[[nodiscard]] std::vector<std::byte> to_bytes(const std::vector<ImportedPart>& parts);
/// Refuses sizes that do not fit the bytes. The submeshes are not validated.
[[nodiscard]] Result<std::vector<ImportedPart>> parts_from_bytes(std::span<const std::byte> bytes);

}  // namespace meshloop
