#include "common/program/program.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <csignal>
#include <exception>
#include <iostream>
#include <optional>
#include <string_view>
#include <vector>

#include "common/base/memory.h"

namespace meshloop {
namespace {

/// What a damaged file says must not drive the terminal.
std::string printable(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

int report(const CLI::App& app, const Error& error) {
  std::cerr << app.get_name() << ": " << printable(error.message) << '\n';
  return exit_code(error.kind);
}

// CLI11 says that a subcommand is required, and not that it does not know the one that was given.
std::optional<std::string> unknown_subcommand(const CLI::App& app) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  const auto words = command->remaining();
  if (words.empty()) return std::nullopt;
  if (words.front().starts_with('-')) {
    return fmt::format("{} has no option '{}' (try --help)", command->get_name(), words.front());
  }
  std::vector<std::string> known;
  for (const CLI::App* subcommand : command->get_subcommands([](const CLI::App*) { return true; })) {
    known.push_back(subcommand->get_name());
  }
  if (known.empty()) return std::nullopt;
  return fmt::format("'{}' is no subcommand of {}; there are {}", words.front(), command->get_name(),
                     fmt::join(known, ", "));
}

int report_parse_error(CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
  if (const auto unknown = unknown_subcommand(app)) return report(app, Error{ErrorKind::usage, *unknown});
  return report(app, Error{ErrorKind::usage, std::string(error.what()) + " (try --help)"});
}

Error empty_value(const std::string& option) {
  return {ErrorKind::usage, option + " is given an empty value; give it one, or leave it out (try --help)"};
}

// CLI11 would take the next word for the value of `--markers=`.
std::optional<Error> value_missing_after_sign(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view word{argv[i]};
    if (word == "--") break;
    if (word.starts_with("--") && word.find('=') == word.size() - 1) {
      return empty_value(std::string{word.substr(0, word.size() - 1)});
    }
  }
  return std::nullopt;
}

// Commands take an empty text for an option that was not given; on a command line it is a variable that was not set.
std::optional<Error> empty_value_in(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    const auto& values = option->results();
    const bool is_empty = std::any_of(values.begin(), values.end(), [](const auto& value) { return value.empty(); });
    if (is_empty) return empty_value(option->get_name());
  }
  for (const CLI::App* chosen : command.get_subcommands()) {
    if (auto found = empty_value_in(*chosen)) return found;
  }
  return std::nullopt;
}

}  // namespace

void prepare(CLI::App& app) {
  app.require_subcommand(1);
  app.set_version_flag("--version", MESHLOOP_VERSION);
  app.get_formatter()->column_width(34);
}

int run_program(CLI::App& app, int argc, char** argv, const Action& action) {
  keep_memory_between_frames();
  // A file that may not grow is an error where it is written, as a full disk is.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    if (const auto missing = value_missing_after_sign(argc, argv)) return report(app, *missing);
    app.parse(argc, argv);
    if (const auto empty = empty_value_in(app)) return report(app, *empty);
    if (const Status done = action(); !done) return report(app, done.error());
    if (!std::cout.flush()) return report(app, {ErrorKind::failed, "the output cannot be written; is the disk full?"});
    return 0;
  } catch (const CLI::ParseError& error) {
    return report_parse_error(app, error);
  } catch (const std::bad_alloc&) {
    return report(app, Error{ErrorKind::failed, "out of memory"});
  } catch (const std::exception& error) {
    return report(app, Error{ErrorKind::failed, std::string("unexpected error: ") + error.what()});
  }
}

}  // namespace meshloop
