#include "common/interchange/replace_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/file.h"

namespace meshloop {
namespace {

tl::unexpected<Error> cannot_write(const std::filesystem::path& file, int error) {
  return fail(fmt::format("cannot write '{}': {}", file.string(), std::generic_category().message(error)));
}

/// 0, or what went wrong.
int write_and_sync(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto count = ::write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return ::fsync(fd) == 0 ? 0 : errno;
}

}  // namespace

Status replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return cannot_write(file, EISDIR);
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
  const auto temporary = folder / fmt::format(".{}.{}.part", file.filename().string(), ::getpid());
  ::unlink(temporary.c_str());
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (fd < 0) return cannot_write(file, errno);
  int error = write_and_sync(fd, bytes);
  if (::close(fd) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    return cannot_write(file, error);
  }
  sync_folder(folder);  // the rename is on the disk only when the folder is
  return {};
}

}  // namespace meshloop
