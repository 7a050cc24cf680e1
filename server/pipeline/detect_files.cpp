#include "server/pipeline/detect_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace meshloop {
namespace {

namespace fs = std::filesystem;

struct NumberedName {
  std::string_view before;
  std::size_t digits;
  std::string_view after;
};

constexpr std::array<NumberedName, 5> kWritten{{{"difference_", 6, ".tiff"},
                                                {"labels_", 6, ".png"},
                                                {"overlay_", 6, ".png"},
                                                {"overlay_depth_", 6, ".png"},
                                                {"region_", 4, ".png"}}};

/// `.NAME.SUFFIX.part`: what a write that was killed leaves (write_file).
std::string_view without_part(std::string_view name) {
  constexpr std::string_view kPart = ".part";
  if (!name.starts_with('.') || !name.ends_with(kPart)) return name;
  name = name.substr(1, name.size() - 1 - kPart.size());
  return name.substr(0, name.rfind('.'));
}

bool is_written_by_detect(std::string_view name) {
  return std::any_of(kWritten.begin(), kWritten.end(), [&](const NumberedName& written) {
    if (!name.starts_with(written.before) || !name.ends_with(written.after)) return false;
    const std::size_t around = written.before.size() + written.after.size();
    if (name.size() < around + written.digits) return false;
    const auto number = name.substr(written.before.size(), name.size() - around);
    return number.find_first_not_of("0123456789") == std::string_view::npos;
  });
}

}  // namespace

Result<std::size_t> remove_files_of_detect(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> old;
  for (fs::directory_iterator entry{folder, error}, end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    const bool is_file = entry->is_regular_file(ignored) && !entry->is_symlink(ignored);
    if (is_file && is_written_by_detect(without_part(entry->path().filename().string()))) old.push_back(entry->path());
  }
  if (error) return fail(fmt::format("cannot look into the folder '{}': {}", folder.string(), error.message()));
  for (const auto& file : old) {
    fs::remove(file, error);
    if (error) return fail(fmt::format("cannot remove '{}' of an earlier run: {}", file.string(), error.message()));
  }
  return old.size();
}

}  // namespace meshloop
