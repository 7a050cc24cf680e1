#pragma once
// Reads small YAML files with one sentence for each mistake. Private to this room.
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace meshloop {

/// The file's root, which must be a map. At most 1 MB.
[[nodiscard]] Result<YAML::Node> load_yaml_map(const std::filesystem::path& file);

/// Refuses keys other than `required` and `optional`, required ones that are missing and keys that stand twice. `where`
/// names the map in messages and is empty for the root.
[[nodiscard]] Status check_keys(const YAML::Node& map, const std::string& where,
                                std::initializer_list<std::string_view> required,
                                std::initializer_list<std::string_view> optional = {});

[[nodiscard]] Result<double> read_number(const YAML::Node& node, const std::string& key);
[[nodiscard]] Result<int> read_integer(const YAML::Node& node, const std::string& key);
[[nodiscard]] Result<bool> read_bool(const YAML::Node& node, const std::string& key);
[[nodiscard]] Result<std::string> read_string(const YAML::Node& node, const std::string& key);
/// Exactly as many finite numbers as `numbers` has room for.
[[nodiscard]] Status read_numbers(const YAML::Node& node, const std::string& key, std::span<double> numbers);

}  // namespace meshloop
