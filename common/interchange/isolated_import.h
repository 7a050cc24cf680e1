#pragma once
#include <filesystem>
#include <functional>

#include "common/base/result.h"
#include "common/interchange/read_file.h"

namespace meshloop {

struct IsolationOptions {
  unsigned max_seconds = 60;
  /// Called here, in the parent, with what the child reports; may be empty.
  std::function<void(double)> progress = {};
};

/// What `read` returns in a child process is returned here. The child has limits on processor time and memory, and
/// leaves no core file; a crash there is an error here. The parts are not validated.
[[nodiscard]] Result<ReadParts> run_isolated(const std::filesystem::path& file, const IsolationOptions& options,
                                             const std::function<Result<ReadParts>(const Progress&)>& read);

}  // namespace meshloop
