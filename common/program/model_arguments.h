#pragma once
// The model file of a command line: its name, the unit of its coordinates, and reading it.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/clock.h"
#include "common/interchange/model_file.h"

namespace meshloop {

struct ModelArguments {
  std::string file;

  /// Adds `option` (as in "--model"; required), --unit and --scale.
  void add_to(CLI::App& command, const std::string& option);

  /// Reads the file, with a line of progress on a terminal.
  [[nodiscard]] Result<ImportedModel> import() const;

 private:
  [[nodiscard]] std::optional<double> unit_m() const;

  std::string unit_;
  std::optional<double> scale_;
};

/// "room.ply: 3.20 x 4.10 x 2.50 m; metres are assumed, the file states no unit".
[[nodiscard]] std::string import_text(const std::string& file, const ImportedModel& imported);
/// {"size_m", "unit_m", "unit": "assumed|stated|given", "stand_in_error_m"}
[[nodiscard]] nlohmann::json import_json(const ImportedModel& imported);

/// Draws "reading room.ply: 40 %" in one line of stderr when that is a terminal, and nothing otherwise. Nothing is
/// drawn in the first half second. The line is gone when the object is.
class ProgressLine {
 public:
  explicit ProgressLine(std::string what);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// From 0 to 1.
  void show(double share);

 private:
  std::string what_;
  Stopwatch watch_;
  bool enabled_;
  bool drawn_ = false;
};

}  // namespace meshloop
