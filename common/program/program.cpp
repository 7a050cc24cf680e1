#include "common/program/program.h"

#include <malloc.h>

#include <csignal>
#include <exception>
#include <iostream>

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

/// Every frame takes and frees pictures of a few megabytes. Left to itself the C library gives the freed end of the
/// heap back to the kernel, which clears its pages again for the next frame: a fifth of the handheld's time.
void keep_memory_between_frames() {
#ifdef __GLIBC__
  // A picture of 1280x720 with 8 bytes a pixel; larger blocks are not kept.
  constexpr int kLargestBlock_bytes = 8 << 20;
  constexpr int kKept_bytes = 32 << 20;
  mallopt(M_MMAP_THRESHOLD, kLargestBlock_bytes);
  mallopt(M_TRIM_THRESHOLD, kKept_bytes);
#endif
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
