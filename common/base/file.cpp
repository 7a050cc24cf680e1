#include "common/base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <random>
#include <system_error>

namespace meshloop {
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_{fd} {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;

  [[nodiscard]] int get() const { return fd_; }
  /// Some file systems report a failed write only here.
  [[nodiscard]] bool close() {
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0;
  }

 private:
  int fd_;
};

tl::unexpected<Error> failed_to(const char* doing, const std::filesystem::path& file, int error) {
  return fail(fmt::format("cannot {} '{}': {}", doing, file.string(), std::generic_category().message(error)));
}

Status read_all(int fd, std::span<std::byte> bytes, const std::filesystem::path& file) {
  while (!bytes.empty()) {
    const auto count = ::read(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failed_to("read", file, errno);
    if (count == 0) return fail(fmt::format("cannot read '{}': it became shorter meanwhile", file.string()));
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

/// 0, or what went wrong.
int write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto count = ::write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return 0;
}

Status write_in_place(const std::filesystem::path& file, int flags, std::span<const std::byte> bytes) {
  FileDescriptor out{::open(file.c_str(), flags | O_WRONLY | O_CREAT | O_CLOEXEC, 0666)};
  if (out.get() < 0) return failed_to("write", file, errno);
  if (const int error = write_all(out.get(), bytes); error != 0) return failed_to("write", file, error);
  if (!out.close()) return failed_to("write", file, errno);
  return {};
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
}

/// 0, or what went wrong; then no temporary file is left.
int write_beside_and_rename(const std::filesystem::path& file, std::span<const std::byte> bytes, bool sync) {
  // mkstemp would make a file that only its owner may read.
  const auto unique = fmt::format("{:08x}", std::random_device{}());
  const auto temporary = folder_of(file) / fmt::format(".{}.{}.part", file.filename().string(), unique);
  FileDescriptor out{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)};
  if (out.get() < 0) return errno;
  struct stat before {};
  if (::stat(file.c_str(), &before) == 0) ::fchmod(out.get(), before.st_mode & 0777);
  int error = write_all(out.get(), bytes);
  if (error == 0 && sync && ::fsync(out.get()) != 0) error = errno;
  if (!out.close() && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) ::unlink(temporary.c_str());
  return error;
}

/// A folder that takes no new file, or a file mounted on its own, may still let its content be written.
bool may_be_written_in_place(int error) {
  return error == EACCES || error == EPERM || error == EROFS || error == EBUSY || error == ENAMETOOLONG;
}

// Opens without waiting for a pipe's other end, and tells the size.
template <class Container>
Result<Container> read_into(const std::filesystem::path& file, std::size_t max_bytes) {
  const FileDescriptor in{::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)};
  if (in.get() < 0) return failed_to("read", file, errno);
  struct stat about {};
  if (::fstat(in.get(), &about) != 0) return failed_to("read", file, errno);
  if (!S_ISREG(about.st_mode)) return fail(fmt::format("cannot read '{}': it is not a file", file.string()));
  const auto size = static_cast<std::size_t>(about.st_size);
  if (size > max_bytes) {
    return fail(fmt::format("'{}' is too large ({} bytes; at most {})", file.string(), size, max_bytes));
  }
  Container bytes(size, typename Container::value_type{});
  if (auto ok = read_all(in.get(), std::as_writable_bytes(std::span{bytes}), file); !ok) return fail(ok.error());
  return bytes;
}

}  // namespace

Result<std::vector<std::byte>> read_file(const std::filesystem::path& file, std::size_t max_bytes) {
  return read_into<std::vector<std::byte>>(file, max_bytes);
}

Result<std::string> read_text_file(const std::filesystem::path& file, std::size_t max_bytes) {
  return read_into<std::string>(file, max_bytes);
}

Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  struct stat about {};
  const bool exists = ::lstat(file.c_str(), &about) == 0;
  // Another name of the file shall see what was written, and what may not be written shall stay.
  const bool stays = exists && (!S_ISREG(about.st_mode) || about.st_nlink > 1 || ::access(file.c_str(), W_OK) != 0);
  if (stays) return write_in_place(file, O_TRUNC, bytes);
  const int error = write_beside_and_rename(file, bytes, false);
  if (may_be_written_in_place(error)) return write_in_place(file, O_TRUNC, bytes);
  return error == 0 ? Status{} : failed_to("write", file, error);
}

Status replace_file(const std::filesystem::path& name, std::span<const std::byte> bytes) {
  std::error_code ignored;
  // A link stays one; what it leads to is replaced.
  const auto target = std::filesystem::weakly_canonical(name, ignored);
  const auto& file = target.empty() ? name : target;
  if (std::filesystem::is_directory(file, ignored)) return failed_to("write", file, EISDIR);
  if (const int error = write_beside_and_rename(file, bytes, true); error != 0) return failed_to("write", file, error);
  sync_folder(folder_of(file));  // the rename is on the disk only when the folder is
  return {};
}

Status write_text_file(const std::filesystem::path& file, const std::string& text) {
  return write_file(file, std::as_bytes(std::span{text}));
}

Status append_text_file(const std::filesystem::path& file, const std::string& text) {
  return write_in_place(file, O_APPEND, std::as_bytes(std::span{text}));
}

void sync_folder(const std::filesystem::path& folder) {
  const FileDescriptor fd{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (fd.get() >= 0) ::fsync(fd.get());
}

}  // namespace meshloop
