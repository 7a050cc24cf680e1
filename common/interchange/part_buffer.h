#pragma once
// Parts as flat bytes, for the way from the importing child process to its parent. The reader trusts nothing in them.
#include <cstddef>
#include <functional>
#include <span>

#include "common/interchange/read_file.h"

namespace meshloop {

/// Hands the bytes out piece by piece, so that there is no second copy of all of them; false from `write` ends it.
using WriteBytes = std::function<bool(std::span<const std::byte>)>;
[[nodiscard]] bool write_parts(const ReadParts& read, const WriteBytes& write);

/// Refuses sizes that do not fit the bytes, and a unit that is none. The submeshes are not validated.
[[nodiscard]] Result<ReadParts> parts_from_bytes(std::span<const std::byte> bytes);

}  // namespace meshloop
