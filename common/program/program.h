#pragma once
// What both programs' command lines share. The only user of CLI11 outside the pipelines.
#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "common/base/result.h"

namespace meshloop {

/// What the chosen subcommand does, set when its options were parsed.
using Action = std::function<Status()>;

/// A top-level parser with `--version`, which wants exactly one subcommand.
void prepare(CLI::App& app);

/// Parses, runs the action and reports: exit code 0 done, 1 failed, 2 wrong usage, 3 hardware missing. An error is one
/// line on stderr. An option with an empty value is wrong usage. No exception leaves this function.
[[nodiscard]] int run_program(CLI::App& app, int argc, char** argv, const Action& action);

}  // namespace meshloop
