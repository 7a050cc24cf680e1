#include "common/program/json_output.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iostream>

namespace meshloop {
namespace {

// Nearest rank: the share 0 is the smallest value, 1 the largest.
double value_at(const std::vector<double>& sorted, double share) {
  const double last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(std::lround(share * last))];
}

std::string text_of(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

nlohmann::json spread_json(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  return {{"median", value_at(values, 0.5)}, {"p95", value_at(values, 0.95)}};
}

std::string json_line(const nlohmann::json& json) {
  return text_of(json, -1);
}

std::string json_page(const nlohmann::json& json) {
  return text_of(json, 2) + '\n';
}

void print_json(const nlohmann::json& json) {
  std::cout << json_page(json);
}

}  // namespace meshloop
