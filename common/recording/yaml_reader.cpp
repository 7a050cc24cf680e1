#include "common/recording/yaml_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "common/base/file.h"

namespace meshloop {
namespace {

constexpr std::size_t kLargestFile = 1u << 20;

std::string inside(const std::string& where, std::string_view key) {
  return where.empty() ? std::string{key} : fmt::format("{}.{}", where, key);
}

template <class T>
Result<T> read_scalar(const YAML::Node& node, const std::string& key, const char* expected) {
  T value{};
  if (!node.IsScalar() || !YAML::convert<T>::decode(node, value)) {
    return fail(fmt::format("'{}' must be {}{}", key, expected,
                            node.IsScalar() ? fmt::format(", not '{:.40}'", node.Scalar()) : ""));
  }
  return value;
}

}  // namespace

Result<YAML::Node> load_yaml_map(const std::filesystem::path& file) {
  const auto text = read_text_file(file, kLargestFile);
  if (!text) return fail(text.error());
  try {
    YAML::Node root = YAML::Load(*text);
    if (!root.IsMap()) return fail(fmt::format("'{}' must hold 'key: value' lines", file.string()));
    return root;
  } catch (const YAML::Exception& error) {
    return fail(fmt::format("'{}', line {}, is not YAML: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

Status check_keys(const YAML::Node& map, const std::string& where, std::initializer_list<std::string_view> required,
                  std::initializer_list<std::string_view> optional) {
  std::vector<std::string_view> known{required};
  known.insert(known.end(), optional.begin(), optional.end());
  if (!map.IsMap()) return fail(fmt::format("'{}' must be a map with the keys {}", where, fmt::join(known, ", ")));
  std::set<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      return fail(fmt::format("unknown key '{:.80}'; use {}", inside(where, key), fmt::join(known, ", ")));
    }
    if (!seen.insert(key).second) return fail(fmt::format("'{}' stands there twice", inside(where, key)));
  }
  for (const auto key : required) {
    if (!seen.contains(std::string{key})) return fail(fmt::format("'{}' is missing", inside(where, key)));
  }
  return {};
}

Result<double> read_number(const YAML::Node& node, const std::string& key) {
  auto value = read_scalar<double>(node, key, "a number");
  if (value && !std::isfinite(*value)) return fail(fmt::format("'{}' must be a finite number", key));
  return value;
}

Result<int> read_integer(const YAML::Node& node, const std::string& key) {
  return read_scalar<int>(node, key, "a whole number");
}

Result<bool> read_bool(const YAML::Node& node, const std::string& key) {
  return read_scalar<bool>(node, key, "true or false");
}

Result<std::string> read_string(const YAML::Node& node, const std::string& key) {
  return read_scalar<std::string>(node, key, "a text");
}

Status read_numbers(const YAML::Node& node, const std::string& key, std::span<double> numbers) {
  if (!node.IsSequence() || node.size() != numbers.size()) {
    return fail(fmt::format("'{}' must be a list of {} numbers", key, numbers.size()));
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto number = read_number(node[i], fmt::format("{}[{}]", key, i));
    if (!number) return fail(number.error());
    numbers[i] = *number;
  }
  return {};
}

}  // namespace meshloop
