#pragma once
// Whole files in memory, with limits, so that every parser works on bytes.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

/// The bytes of a regular file. Refuses what is not a regular file, and a file of more than `max_bytes`.
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& file, std::size_t max_bytes);
/// The same as text.
[[nodiscard]] Result<std::string> read_text_file(const std::filesystem::path& file, std::size_t max_bytes);

/// Replaces the file's content. A folder that is missing, a write that is refused and a full disk are errors; what
/// stood there before stays then. The bytes are written to a temporary file beside the target (".NAME.NUMBER.part"),
/// which is renamed, or removed after an error; so the file belongs to who wrote it last. They are written in place,
/// and an error may leave a part of them there, through links, into pipes and devices, into a file that has another
/// name too, and where no file can be made beside it. A file that may not be written stays.
[[nodiscard]] Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
[[nodiscard]] Status write_text_file(const std::filesystem::path& file, const std::string& text);
/// The same, and brought to the disk: after a loss of power the old bytes or all of the new ones stand there. Never in
/// place; other names of the file keep the old bytes, and a link to it stays one.
[[nodiscard]] Status replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
/// Adds text at the end of a file (made if missing) in one write, so that a killed process leaves all of it or nothing.
[[nodiscard]] Status append_text_file(const std::filesystem::path& file, const std::string& text);

/// Waits until names made or replaced in the folder are on the disk. Best effort: not every file system can.
void sync_folder(const std::filesystem::path& folder);

}  // namespace meshloop
