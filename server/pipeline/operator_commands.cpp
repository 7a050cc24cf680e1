#include "server/pipeline/operator_commands.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "server/pipeline/operator_name.h"

namespace meshloop {
namespace {

/// A longer line must stay longer than any command, also after the end that some terminals add to it.
constexpr std::size_t kMostKept = kLongestCommand + 2;
/// A flood of lines must not keep the station from its frames.
constexpr int kMostReads = 8;
constexpr const char* kBlanks = " \t";

/// The first word, and what follows it.
std::pair<std::string, std::string> split_word(const std::string& text) {
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string::npos) return {};
  const auto end = text.find_first_of(kBlanks, begin);
  if (end == std::string::npos) return {text.substr(begin), {}};
  const auto rest = text.find_first_not_of(kBlanks, end);
  if (rest == std::string::npos) return {text.substr(begin, end - begin), {}};
  return {text.substr(begin, end - begin), text.substr(rest, text.find_last_not_of(kBlanks) + 1 - rest)};
}

/// The list of ids at the beginning, without blanks around its commas, and what follows it.
std::pair<std::string, std::string> split_list(const std::string& text) {
  auto [list, rest] = split_word(text);
  while (!rest.empty() && (list.ends_with(',') || rest.starts_with(','))) {
    auto [word, after] = split_word(rest);
    list += word;
    rest = std::move(after);
  }
  return {std::move(list), std::move(rest)};
}

Result<OperatorCommand> parse_accept_line(const std::string& rest) {
  OperatorCommand command{OperatorCommand::What::accept, {}};
  const auto [ids, more] = split_list(rest);
  if (ids.empty()) return fail("accept takes all, or ids such as 1,3");
  if (!more.empty()) return fail(fmt::format("accept takes all, or ids such as 1,3, not '{}'", rest));
  if (auto ok = parse_accept(ids, "accept", command.decisions); !ok) return fail(ok.error());
  return command;
}

Result<OperatorCommand> parse_reject_line(const std::string& rest) {
  OperatorCommand command{OperatorCommand::What::reject, {}};
  const auto [list, reason] = split_list(rest);
  if (list.empty()) return fail("reject takes ids such as 2,4, and a reason if you like");
  auto ids = parse_proposal_ids(list);
  if (!ids) return fail(ids.error());
  if (!reason.empty()) {
    if (const auto wrong = why_not_one_line(reason, "a reason", kLongestReason); !wrong.empty()) return fail(wrong);
  }
  command.decisions.reject = std::move(*ids);
  command.decisions.reason = reason;
  return command;
}

}  // namespace

Result<OperatorCommand> parse_command(const std::string& line) {
  constexpr std::array<std::pair<const char*, OperatorCommand::What>, 3> kSingle{
      {{"undo", OperatorCommand::What::undo},
       {"redo", OperatorCommand::What::redo},
       {"list", OperatorCommand::What::list}}};
  if (line.size() > kLongestCommand) {
    return fail(
        fmt::format("a command has at most {} bytes; name fewer ids at once, or ranges such as 1-9", kLongestCommand));
  }
  const auto [word, rest] = split_word(line);
  if (word == "accept") return parse_accept_line(rest);
  if (word == "reject") return parse_reject_line(rest);
  for (const auto& [name, what] : kSingle) {
    if (word != name) continue;
    if (!rest.empty()) return fail(fmt::format("{} takes nothing", name));
    return OperatorCommand{what, {}};
  }
  return fail("commands are accept, reject, undo, redo and list");
}

std::vector<std::string> CommandLines::read() {
  std::vector<std::string> lines;
  for (int reads = 0; fd_ >= 0 && reads < kMostReads; ++reads) {
    pollfd waiting{fd_, POLLIN, 0};
    if (::poll(&waiting, 1, 0) <= 0) break;
    std::array<char, 4096> bytes;
    const auto count = ::read(fd_, bytes.data(), bytes.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) break;
    if (count <= 0) {
      fd_ = -1;
      finish_line(lines);
      break;
    }
    take(bytes.data(), static_cast<std::size_t>(count), lines);
  }
  return lines;
}

void CommandLines::take(const char* bytes, std::size_t count, std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < count; ++i) {
    if (bytes[i] == '\n') {
      finish_line(lines);
    } else if (begun_.size() < kMostKept) {
      begun_ += bytes[i];
    }
  }
}

void CommandLines::finish_line(std::vector<std::string>& lines) {
  if (begun_.ends_with('\r')) begun_.pop_back();
  const bool is_blank = begun_.find_first_not_of(kBlanks) == std::string::npos;
  if (!is_blank || begun_.size() > kLongestCommand) lines.push_back(std::move(begun_));
  begun_.clear();
}

}  // namespace meshloop
