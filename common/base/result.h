#pragma once
// Errors are values. A message is one sentence that says what is wrong and, where it is known, what to do.
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace meshloop {

/// What kind of failure this is; the programs' exit codes follow from it (1, 2, 3 in this order).
enum class ErrorKind { failed, usage, hardware_missing };

struct Error {
  ErrorKind kind = ErrorKind::failed;
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

[[nodiscard]] inline tl::unexpected<Error> fail(std::string message, ErrorKind kind = ErrorKind::failed) {
  return tl::unexpected<Error>(Error{kind, std::move(message)});
}

/// Hands an error on, with what was being done in front: "reading rig.yaml: no such file".
[[nodiscard]] inline tl::unexpected<Error> fail(const std::string& doing, const Error& error) {
  return tl::unexpected<Error>(Error{error.kind, doing + ": " + error.message});
}

[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

[[nodiscard]] constexpr int exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::usage:
      return 2;
    case ErrorKind::hardware_missing:
      return 3;
    case ErrorKind::failed:
      break;
  }
  return 1;
}

}  // namespace meshloop
