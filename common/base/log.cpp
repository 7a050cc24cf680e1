#include "common/base/log.h"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace meshloop {
namespace {

LogLevel lowest_level() {
  const char* wanted = std::getenv("MESHLOOP_LOG");
  const std::string_view name = wanted ? wanted : "warning";
  if (name == "info") return LogLevel::info;
  if (name == "error") return LogLevel::error;
  return LogLevel::warning;
}

const char* name_of(LogLevel level) {
  switch (level) {
    case LogLevel::info:
      return "info";
    case LogLevel::warning:
      return "warning";
    case LogLevel::error:
      break;
  }
  return "error";
}

}  // namespace

void log_line(LogLevel level, std::string_view text) {
  if (level < lowest_level()) return;
  const std::string line = fmt::format("meshloop: {}: {}\n", name_of(level), text);
  std::fwrite(line.data(), 1, line.size(), stderr);  // one write a line, so that threads' lines do not mix
}

}  // namespace meshloop
