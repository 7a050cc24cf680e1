#include "common/interchange/child_result.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "common/interchange/part_buffer.h"

namespace meshloop {
namespace {

constexpr std::byte kParts{1};

bool write_all(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto count = ::write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

/// Kind and content. The child has ended, so nobody shortens them.
Result<ReadParts> result_of(std::span<const std::byte> bytes) {
  const auto content = bytes.subspan(1);
  if (bytes.front() == kParts) return parts_from_bytes(content);
  return fail(std::string{reinterpret_cast<const char*>(content.data()), content.size()});
}

}  // namespace

void Descriptor::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

Status ChildResult::open() {
  memory_.take(::memfd_create("meshloop-import", MFD_CLOEXEC));
  if (memory_.get() < 0) return fail(fmt::format("no memory for the result: {}", std::strerror(errno)));
  return {};
}

bool ChildResult::write(const Result<ReadParts>& read) const {
  if (!read) return write_error(read.error().message);
  const auto write = [this](std::span<const std::byte> bytes) { return write_all(memory_.get(), bytes); };
  return write(std::span{&kParts, 1}) && write_parts(*read, write);
}

bool ChildResult::write_error(const std::string& message) const {
  constexpr std::byte kError{2};
  return write_all(memory_.get(), std::span{&kError, 1}) && write_all(memory_.get(), std::as_bytes(std::span{message}));
}

std::optional<Result<ReadParts>> ChildResult::read() const {
  struct stat info {};
  if (::fstat(memory_.get(), &info) != 0 || info.st_size <= 0) return std::nullopt;
  const auto size = static_cast<std::size_t>(info.st_size);
  void* const start = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, memory_.get(), 0);
  if (start == MAP_FAILED) return fail("there is not enough memory for what it holds");
  auto result = result_of({static_cast<const std::byte*>(start), size});
  ::munmap(start, size);
  return result;
}

Status ChildProgress::open() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return fail(fmt::format("no pipe: {}", std::strerror(errno)));
  from_child_.take(ends[0]);
  to_parent_.take(ends[1]);
  // The child never waits for a parent that does not read.
  ::fcntl(ends[1], F_SETFL, O_NONBLOCK);
  return {};
}

Progress ChildProgress::reporter() {
  from_child_.close();
  return [this, last = -1](double share) mutable {
    const int percent = static_cast<int>(std::lround(100 * std::clamp(share, 0.0, 1.0)));
    if (percent <= last) return;
    last = percent;
    const auto byte = static_cast<std::uint8_t>(percent);
    // One that gets lost is followed by the next.
    [[maybe_unused]] const auto written = ::write(to_parent_.get(), &byte, 1);
  };
}

void ChildProgress::follow(const std::function<void(double)>& progress) {
  to_parent_.close();
  std::array<std::uint8_t, 128> percents{};
  for (;;) {
    const auto count = ::read(from_child_.get(), percents.data(), percents.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    const int percent = percents[static_cast<std::size_t>(count) - 1];
    if (progress) progress(std::min(percent, 100) / 100.0);
  }
}

}  // namespace meshloop
