#include "common/base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
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

Status write_all(const std::filesystem::path& file, int flags, std::span<const std::byte> bytes) {
  FileDescriptor out{::open(file.c_str(), flags | O_WRONLY | O_CREAT | O_CLOEXEC, 0666)};
  if (out.get() < 0) return failed_to("write", file, errno);
  while (!bytes.empty()) {
    const auto count = ::write(out.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failed_to("write", file, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  if (!out.close()) return failed_to("write", file, errno);
  return {};
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
  return write_all(file, O_TRUNC, bytes);
}

Status write_text_file(const std::filesystem::path& file, const std::string& text) {
  return write_file(file, std::as_bytes(std::span{text}));
}

Status append_text_file(const std::filesystem::path& file, const std::string& text) {
  return write_all(file, O_APPEND, std::as_bytes(std::span{text}));
}

void sync_folder(const std::filesystem::path& folder) {
  const FileDescriptor fd{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (fd.get() >= 0) ::fsync(fd.get());
}

}  // namespace meshloop
