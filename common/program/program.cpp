#include "common/program/program.h"

#include <csignal>
#include <exception>
#include <iostream>

#include "common/base/memory.h"

namespace meshloop {
namespace {

int report(const CLI::App& app, const Error& error) {
  std::cerr << app.get_name() << ": " << error.message << '\n';
  return exit_code(error.kind);
}

int report_parse_error(CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help and --version
  return report(app, Error{ErrorKind::usage, std::string(error.what()) + " (try --help)"});
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
    app.parse(argc, argv);
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
