#include "server/store/writer_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

namespace meshloop {
namespace {

constexpr std::chrono::seconds kPatience{1};
constexpr std::chrono::milliseconds kPause{20};

}  // namespace

Result<WriterLock> WriterLock::take(const std::filesystem::path& scene) {
  // Whatever symbolic link led here, the lock is the file's.
  std::error_code unknown;
  const auto real = std::filesystem::weakly_canonical(scene, unknown);
  const std::string name = (unknown ? scene : real).string() + "-lock";
  const int fd = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd < 0) {
    return fail(fmt::format("'{}' cannot be written: {}", scene.string(), std::generic_category().message(errno)));
  }
  WriterLock lock{fd};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) {
      return fail(fmt::format("'{}' cannot be locked: {}", scene.string(), std::generic_category().message(errno)));
    }
    if (std::chrono::steady_clock::now() > deadline) {
      return fail(fmt::format("another program is writing to '{}'; stop it first", scene.string()));
    }
    std::this_thread::sleep_for(kPause);
  }
  return lock;
}

WriterLock::~WriterLock() {
  if (fd_ >= 0) ::close(fd_);
}

WriterLock::WriterLock(WriterLock&& other) noexcept : fd_{std::exchange(other.fd_, -1)} {}

}  // namespace meshloop
