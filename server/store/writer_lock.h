#pragma once
#include <filesystem>
#include <optional>

#include "common/base/result.h"

namespace meshloop {

/// The right to write to a scene: one process at a time, until the owner dies. Held by a lock on an empty file beside
/// the scene (FILE-lock), not on the scene itself, whose locks belong to SQLite.
class WriterLock {
 public:
  /// Waits a second for another writer to finish.
  [[nodiscard]] static Result<WriterLock> take(const std::filesystem::path& scene);
  ~WriterLock();
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&&) = delete;

 private:
  explicit WriterLock(int fd) : fd_{fd} {}
  int fd_;
};

}  // namespace meshloop
