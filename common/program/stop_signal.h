#pragma once

namespace meshloop {

/// From now on SIGINT and SIGTERM no longer end the process at once; they make `stop_requested` true.
void catch_stop_signals();
/// Any thread.
[[nodiscard]] bool stop_requested();

}  // namespace meshloop
