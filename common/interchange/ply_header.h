#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of one value in a binary file.
[[nodiscard]] std::size_t size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  bool is_list = false;
  /// Of the number of values that precedes a list.
  PlyType count_type = PlyType::uint8;
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding : std::uint8_t { ascii, little_endian, big_endian };
  Encoding encoding = Encoding::ascii;
  std::vector<PlyElement> elements;
  /// Bytes of the header, its last line's end included.
  std::size_t size = 0;
};

/// The text from `ply` to `end_header`.
[[nodiscard]] Result<PlyHeader> parse_ply_header(std::string_view content);

}  // namespace meshloop
