#include "common/program/model_arguments.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>

#include "common/program/arguments.h"

namespace meshloop {
namespace {

constexpr double kQuiet_ms = 500;

const std::map<std::string, double>& units() {
  static const std::map<std::string, double> kUnits{
      {"mm", 0.001}, {"cm", 0.01}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}};
  return kUnits;
}

std::string name_of(const std::string& file) {
  return std::filesystem::path{file}.filename().string();
}

const char* source_name(LengthUnit::Source source) {
  switch (source) {
    case LengthUnit::Source::assumed:
      return "assumed";
    case LengthUnit::Source::stated:
      return "stated";
    case LengthUnit::Source::given:
      break;
  }
  return "given";
}

// Three digits that say something, down to a micrometre; metres have two after the point.
std::string length_text(float metres) {
  constexpr int kMicrometres = 6;
  if (!(metres >= 5e-7F)) return "0.00";
  const int digits = std::clamp(2 - static_cast<int>(std::floor(std::log10(metres))), 2, kMicrometres);
  return fmt::format("{:.{}f}", metres, digits);
}

}  // namespace

void ModelArguments::add_to(CLI::App& command, const std::string& option) {
  command.add_option(option, file, model_file_kinds())->required();
  auto* const unit = command.add_option(
      "--unit", unit_, "unit of the model file, whatever it says; without this and --scale what it says, else metres");
  std::vector<std::string> names;
  for (const auto& [name, metres] : units()) names.push_back(name);
  unit->check(CLI::IsMember(names));
  command.add_option("--scale", scale_, "metres per unit of the model file, in place of --unit")
      ->check(between(1e-9, 1e9))
      ->excludes(unit);
}

std::optional<double> ModelArguments::unit_m() const {
  if (scale_) return scale_;
  const auto found = units().find(unit_);
  return found == units().end() ? std::nullopt : std::optional{found->second};
}

Result<ImportedModel> ModelArguments::import() const {
  ProgressLine line{"reading " + name_of(file)};
  ImportOptions options;
  options.unit_m = unit_m();
  options.progress = [&line](double share) { line.show(share); };
  return import_as_model(file, options);
}

std::string import_text(const std::string& file, const ImportedModel& imported) {
  const auto& size = imported.size_m;
  auto text = fmt::format("{}: {} x {} x {} m; {}", name_of(file), length_text(size.x()), length_text(size.y()),
                          length_text(size.z()), to_text(imported.unit));
  if (imported.stand_in_error_m > 0) {
    text += fmt::format("; where shapes are kept or sent as triangles these are off by up to {:.1f} mm",
                        1000 * imported.stand_in_error_m);
  }
  return text;
}

nlohmann::json import_json(const ImportedModel& imported) {
  const auto& size = imported.size_m;
  return {{"stand_in_error_m", imported.stand_in_error_m},
          {"size_m", {size.x(), size.y(), size.z()}},
          {"unit_m", imported.unit.metres},
          {"unit", source_name(imported.unit.source)}};
}

ProgressLine::ProgressLine(std::string what) : what_{std::move(what)}, enabled_{::isatty(STDERR_FILENO) == 1} {}

ProgressLine::~ProgressLine() {
  if (drawn_) std::fputs("\r\x1b[K", stderr);
}

void ProgressLine::show(double share) {
  if (!enabled_ || watch_.milliseconds() < kQuiet_ms) return;
  drawn_ = true;
  std::fputs(fmt::format("\r\x1b[K{}: {:.0f} %", what_, 100 * share).c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace meshloop
