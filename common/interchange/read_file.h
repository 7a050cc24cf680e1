#pragma once
// A model file to parts, in the process that calls. import.cpp calls it in a child process with limits.
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/interchange/model_file.h"

namespace meshloop {

/// Called with a growing share between 0 and 1 while a file is read. Never empty.
using Progress = std::function<void(double)>;

struct ReadParts {
  std::vector<ImportedPart> parts;
  LengthUnit unit;
};

/// Reads one format. The parts' positions are in the file's unit; they are neither welded nor split nor validated. May
/// crash on a malformed file.
using FormatReader = Result<ReadParts> (*)(const std::filesystem::path& file, const Progress& progress);

struct ModelFormat {
  /// As in ".ply".
  std::string_view ending;
  FormatReader read;
};

/// All formats of this build.
[[nodiscard]] std::span<const ModelFormat> model_formats();

/// The format of the file's ending; null when there is none.
[[nodiscard]] const ModelFormat* format_of(const std::filesystem::path& file);

/// Parts in metres: read, scaled, of a size that can be meant, valid, welded and split.
[[nodiscard]] Result<ReadParts> read_file(const std::filesystem::path& file, const ImportOptions& options,
                                          const Progress& progress);

}  // namespace meshloop
