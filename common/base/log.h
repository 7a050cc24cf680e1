#pragma once
// One line a message on stderr. Thread-safe. stdout belongs to results.
#include <fmt/format.h>

#include <string_view>
#include <utility>

namespace meshloop {

enum class LogLevel { info, warning, error };

/// Writes "meshloop: warning: text". Messages below the level that MESHLOOP_LOG names (info, warning, error) are
/// not written; the default is warning.
void log_line(LogLevel level, std::string_view text);

template <class... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::info, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::warning, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void log_error(fmt::format_string<Args...> format, Args&&... args) {
  log_line(LogLevel::error, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace meshloop
