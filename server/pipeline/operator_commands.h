#pragma once
// What an operator types while the station runs: one command a line.
#include <cstddef>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/pipeline/decisions.h"

namespace meshloop {

struct OperatorCommand {
  enum class What { accept, reject, undo, redo, list };
  What what = What::list;
  /// Of accept and reject.
  Decisions decisions;
};

/// A line's most bytes.
inline constexpr std::size_t kLongestCommand = 2000;

/// "accept all", "accept 1,3" or "1, 3", "reject 2 too noisy", "undo", "redo", "list". Refuses a line of more than
/// kLongestCommand bytes, whatever it says.
[[nodiscard]] Result<OperatorCommand> parse_command(const std::string& line);

/// Lines of a file descriptor that is read without waiting. One thread.
class CommandLines {
 public:
  /// -1: there are none.
  explicit CommandLines(int fd) : fd_{fd} {}

  /// Whole lines that came since the last call, without their ends, blank ones left out; at the end also a last one
  /// that has no end. Of a line of more than kLongestCommand bytes so much comes that parse_command refuses it.
  [[nodiscard]] std::vector<std::string> read();
  /// Nothing will come any more.
  [[nodiscard]] bool ended() const { return fd_ < 0; }

 private:
  void take(const char* bytes, std::size_t count, std::vector<std::string>& lines);
  void finish_line(std::vector<std::string>& lines);

  int fd_;
  std::string begun_;
};

}  // namespace meshloop
