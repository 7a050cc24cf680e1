#pragma once
// Values on the command line that both programs, or several subcommands, take.
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

/// Frame numbers as `0,5,10-20`, in growing order and each once. Refuses numbers above a million.
[[nodiscard]] Result<std::vector<int>> parse_frame_list(const std::string& text);

/// For numbers on the command line; unlike CLI::Range it refuses NaN too.
[[nodiscard]] CLI::Validator between(double smallest, double largest);

/// For counters on the command line, in decimal digits; CLI11 would take -1 for the largest one.
[[nodiscard]] CLI::Validator counter();

/// `KIND` or `KIND:REST` split at the first colon.
struct KindAndRest {
  std::string kind;
  std::string rest;
};
[[nodiscard]] KindAndRest split_kind(const std::string& text);

}  // namespace meshloop
