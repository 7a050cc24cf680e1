#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

#include "common/base/result.h"

namespace meshloop {

/// A file's bytes without a copy of them. Reading beyond the end of a file that another process shortens meanwhile
/// ends the process (SIGBUS): for the importing child only.
class MappedFile {
 public:
  [[nodiscard]] static Result<MappedFile> open(const std::filesystem::path& file);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&&) = delete;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  [[nodiscard]] std::string_view text() const { return {reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_{bytes} {}
  std::span<const std::byte> bytes_;
};

}  // namespace meshloop
