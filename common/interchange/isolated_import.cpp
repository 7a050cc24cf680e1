#include "common/interchange/isolated_import.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include "common/interchange/child_result.h"

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

/// How the child ends that cannot hand its result over. No library ends a process with it.
constexpr int kNoRoomForResult = 87;

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
  limit.rlim_cur = std::min(value, limit.rlim_cur);
  ::setrlimit(resource, &limit);
}

/// Addresses that the child may have.
struct MemoryLimit {
  rlim_t bytes = 0;
  /// Somebody else set a lower one than this program would.
  bool is_inherited = false;
};

MemoryLimit memory_limit() {
  const rlim_t ours = addresses_in_use() + kMaxMemory;
  rlimit present{};
  const bool is_lower = ::getrlimit(RLIMIT_AS, &present) == 0 && present.rlim_cur < ours;
  return is_lower ? MemoryLimit{present.rlim_cur, true} : MemoryLimit{ours, false};
}

std::string too_little_memory(const MemoryLimit& limit) {
  if (!limit.is_inherited) return fmt::format("it needs more than {} GiB of memory", kMaxMemory >> 30);
  return fmt::format("it needs more memory than this program may have, {} MiB in all (ulimit -v)", limit.bytes >> 20);
}

/// A crash for lack of memory looks like any other.
std::string crashed(const MemoryLimit& limit) {
  if (!limit.is_inherited) return "the importer crashed; the file is probably damaged";
  return fmt::format(
      "the importer crashed; the file is damaged, or too large for the {} MiB of memory that this program "
      "may have (ulimit -v)",
      limit.bytes >> 20);
}

void enter_child(unsigned max_seconds, const MemoryLimit& memory) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) ::signal(signal, SIG_DFL);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_CPU, max_seconds);
  if (kMemoryIsLimited) set_limit(RLIMIT_AS, memory.bytes);
}

// noexcept: the child must not go on as a second program; what nobody catches ends it, and reads as a crash.
bool read_into(const ChildResult& result, const MemoryLimit& memory,
               const std::function<Result<ReadParts>()>& read) noexcept {
  try {
    const auto parts = read();
    // assimp catches it itself, and hands on its name.
    const bool had_too_little = !parts && parts.error().message.find("bad_alloc") != std::string::npos;
    return had_too_little ? result.write_error(too_little_memory(memory)) : result.write(parts);
  } catch (const std::bad_alloc&) {
    return result.write_error(too_little_memory(memory));
  } catch (const std::exception& error) {
    return result.write_error(error.what());
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

Result<ReadParts> result_of(const std::filesystem::path& file, int status, const ChildResult& result,
                            unsigned max_seconds, const MemoryLimit& memory) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
    return unreadable(file, "the importer was stopped, for lack of memory or by its limit of time");
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
    return unreadable(file, fmt::format("the importer was stopped after {} s of processor time", max_seconds));
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNoRoomForResult) {
    return unreadable(file, "there is not enough memory for what it holds, or it may not be passed on (ulimit -f)");
  }
  auto read = WIFEXITED(status) && WEXITSTATUS(status) == 0 ? result.read() : std::nullopt;
  if (!read) return unreadable(file, crashed(memory));
  if (!*read) return unreadable(file, read->error().message);
  return std::move(*read);
}

}  // namespace

Result<ReadParts> run_isolated(const std::filesystem::path& file, const IsolationOptions& options,
                               const std::function<Result<ReadParts>(const Progress&)>& read) {
  ChildResult result;
  ChildProgress progress;
  for (const Status& opened : {result.open(), progress.open()}) {
    if (!opened) return unreadable(file, opened.error().message);
  }
  const MemoryLimit memory = memory_limit();
  const pid_t child = ::fork();
  if (child < 0) return unreadable(file, fmt::format("no process for the importer: {}", std::strerror(errno)));
  if (child == 0) {
    enter_child(options.max_seconds, memory);
    const Progress report = progress.reporter();
    ::_exit(read_into(result, memory, [&] { return read(report); }) ? 0 : kNoRoomForResult);
  }
  progress.follow(options.progress);
  return result_of(file, wait_for(child), result, options.max_seconds, memory);
}

}  // namespace meshloop
