#pragma once
// What the programs print with --json.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace meshloop {

/// {"median": ..., "p95": ...}; null without values.
[[nodiscard]] nlohmann::json spread_json(std::vector<double> values);

/// One line, or indented. Bytes that are no UTF-8 (a file may be named with any) become U+FFFD: JSON has no other way.
[[nodiscard]] std::string json_line(const nlohmann::json& json);
[[nodiscard]] std::string json_page(const nlohmann::json& json);

/// One indented document on stdout.
void print_json(const nlohmann::json& json);

}  // namespace meshloop
