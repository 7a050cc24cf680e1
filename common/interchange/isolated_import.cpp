#include "common/interchange/isolated_import.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <span>

#include "common/interchange/part_buffer.h"
#include "common/interchange/scene_reader.h"

namespace meshloop {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MESHLOOP_HAS_SHADOW_MEMORY 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MESHLOOP_HAS_SHADOW_MEMORY 1
#endif
#endif
#ifdef MESHLOOP_HAS_SHADOW_MEMORY
/// The sanitizers reserve terabytes of addresses, so that a limit on them would end the child at once.
constexpr bool kMemoryIsLimited = false;
#else
constexpr bool kMemoryIsLimited = true;
#endif

/// Addresses that reading may take beyond those that the process has already.
constexpr rlim_t kMaxMemory = rlim_t{4} << 30;

constexpr std::byte kParts{1};
constexpr std::byte kError{2};

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_{fd} {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

rlim_t addresses_in_use() {
  unsigned long pages = 0;
  if (std::FILE* statm = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(statm, "%lu", &pages) != 1) pages = 0;
    std::fclose(statm);
  }
  return static_cast<rlim_t>(pages) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
}

void set_limit(__rlimit_resource resource, rlim_t value) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(value, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

void enter_child(unsigned max_seconds) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) ::signal(signal, SIG_DFL);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_CPU, max_seconds);
  if (kMemoryIsLimited) set_limit(RLIMIT_AS, addresses_in_use() + kMaxMemory);
}

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto count = ::write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

bool write_error(int fd, const std::string& message) {
  return write_all(fd, std::span{&kError, 1}) && write_all(fd, std::as_bytes(std::span{message}));
}

template <class Read>
bool read_into(int fd, const std::filesystem::path& file, Read read) {
  try {
    const auto parts = read(file);
    if (!parts) return write_error(fd, parts.error().message);
    return write_all(fd, std::span{&kParts, 1}) && write_all(fd, to_bytes(*parts));
  } catch (const std::bad_alloc&) {
    return write_error(fd, fmt::format("it needs more than {} GiB of memory", kMaxMemory >> 30));
  } catch (const std::exception& error) {
    return write_error(fd, error.what());
  }
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

tl::unexpected<Error> unreadable(const std::filesystem::path& file, std::string why) {
  // A reader's message may have several lines; one sentence leaves here.
  for (char& c : why) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return fail(fmt::format("'{}' could not be read: {}", file.string(), why));
}

Result<std::vector<std::byte>> all_bytes(int fd) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return fail(std::strerror(errno));
  std::vector<std::byte> bytes(static_cast<std::size_t>(info.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto count = ::pread(fd, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return fail("the importer's result could not be read");
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

Result<std::vector<ImportedPart>> result_of(const std::filesystem::path& file, int status, int fd,
                                            unsigned max_seconds) {
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    return unreadable(file, fmt::format("the importer was stopped after {} s of processor time", max_seconds));
  }
  const auto bytes = all_bytes(fd);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !bytes || bytes->empty()) {
    return unreadable(file, "the importer crashed; the file is probably damaged");
  }
  const auto content = std::span{*bytes}.subspan(1);
  if (bytes->front() == kParts) return parts_from_bytes(content);
  return unreadable(file, std::string{reinterpret_cast<const char*>(content.data()), content.size()});
}

}  // namespace

Result<std::vector<ImportedPart>> run_isolated(
    const std::filesystem::path& file, unsigned max_seconds,
    Result<std::vector<ImportedPart>> (*read)(const std::filesystem::path&)) {
  const Descriptor result{::memfd_create("meshloop-import", MFD_CLOEXEC)};
  if (result.get() < 0) return unreadable(file, fmt::format("no memory for the result: {}", std::strerror(errno)));
  const pid_t child = ::fork();
  if (child < 0) return unreadable(file, fmt::format("no process for the importer: {}", std::strerror(errno)));
  if (child == 0) {
    enter_child(max_seconds);
    ::_exit(read_into(result.get(), file, read) ? 0 : 1);
  }
  return result_of(file, wait_for(child), result.get(), max_seconds);
}

Result<std::vector<ImportedPart>> read_parts_isolated(const std::filesystem::path& file, unsigned max_seconds) {
  return run_isolated(file, max_seconds, read_parts);
}

}  // namespace meshloop
