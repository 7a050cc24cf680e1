#pragma once
#include <sys/stat.h>

#include <filesystem>
#include <utility>

#include "common/base/result.h"

namespace meshloop {

/// The file that a name led to when it was opened: SQLite goes on writing to it when the name leads elsewhere.
class FileIdentity {
 public:
  [[nodiscard]] static Result<FileIdentity> of(const std::filesystem::path& file);
  /// An error when the name leads to another file by now, or to none.
  [[nodiscard]] Status check() const;
  /// An error when the file was written to since, too.
  [[nodiscard]] Status check_content() const;

 private:
  FileIdentity(std::filesystem::path file, const struct stat& about) : file_{std::move(file)}, about_{about} {}
  std::filesystem::path file_;
  struct stat about_;
};

}  // namespace meshloop
