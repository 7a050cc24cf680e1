#pragma once
// A second process for tests of what crosses a process boundary. Fork before this process starts threads or DDS.
#include <net/if.h>
#include <sched.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>

namespace meshloop::test {

/// Runs a function in a child process; its result is the child's exit status. Killed with its owner.
class ChildProcess {
 public:
  explicit ChildProcess(const std::function<int()>& run) : pid_{fork()} {
    if (pid_ != 0) return;
    int status = 99;
    try {
      status = run();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "child process: %s\n", error.what());
    }
    std::fflush(nullptr);
    _exit(status);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess() {
    if (pid_ <= 0) return;
    send(SIGKILL);
    wait();
  }

  void send(int signal) const {
    if (pid_ > 0) ::kill(pid_, signal);
  }
  /// The exit status; 128 and more when a signal ended it.
  int wait() {
    int status = 0;
    while (pid_ > 0 && waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_;
};

/// Moves this process (it must be single-threaded) into a network of its own that has the loopback interface and
/// nothing else. False where the system does not allow that.
inline bool enter_network_with_loopback_only() {
  if (unshare(CLONE_NEWNET) != 0 && unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  const int any_socket = socket(AF_INET, SOCK_DGRAM, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  const bool is_up = ioctl(any_socket, SIOCSIFFLAGS, &request) == 0;
  close(any_socket);
  return is_up;
}

}  // namespace meshloop::test
