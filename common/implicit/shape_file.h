#pragma once
// Text files of shapes (YAML); README.md has an example.
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/implicit/shape.h"

namespace meshloop {

struct NamedShape {
  std::string name;
  Shape shape;
};

/// Refuses unknown keys, sizes that are not positive, shapes without an end; the message names the line.
[[nodiscard]] Result<std::vector<NamedShape>> parse_shapes(const std::string& text);
[[nodiscard]] Result<std::vector<NamedShape>> read_shapes(const std::filesystem::path& file);

}  // namespace meshloop
