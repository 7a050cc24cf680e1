#pragma once
#include <sys/types.h>

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

 private:
  FileIdentity(std::filesystem::path file, dev_t device, ino_t number)
      : file_{std::move(file)}, device_{device}, number_{number} {}
  std::filesystem::path file_;
  dev_t device_;
  ino_t number_;
};

}  // namespace meshloop
