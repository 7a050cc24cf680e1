#include "common/interchange/ply_header.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <optional>
#include <utility>

namespace meshloop {
namespace {

constexpr std::size_t kLongestHeader = 1 << 20;

std::optional<PlyType> type_of(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames{{
      {"char", PlyType::int8},
      {"int8", PlyType::int8},
      {"uchar", PlyType::uint8},
      {"uint8", PlyType::uint8},
      {"short", PlyType::int16},
      {"int16", PlyType::int16},
      {"ushort", PlyType::uint16},
      {"uint16", PlyType::uint16},
      {"int", PlyType::int32},
      {"int32", PlyType::int32},
      {"uint", PlyType::uint32},
      {"uint32", PlyType::uint32},
      {"float", PlyType::float32},
      {"float32", PlyType::float32},
      {"double", PlyType::float64},
      {"float64", PlyType::float64},
  }};
  for (const auto& [known, type] : kNames) {
    if (known == name) return type;
  }
  return std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlank = " \t\r";
  for (auto start = line.find_first_not_of(kBlank); start != std::string_view::npos;) {
    const auto end = std::min(line.find_first_of(kBlank, start), line.size());
    words.push_back(line.substr(start, end - start));
    start = line.find_first_not_of(kBlank, end);
  }
  return words;
}

using Words = std::vector<std::string_view>;

bool add_format(const Words& words, PlyHeader& header) {
  if (words.size() != 3) return false;
  if (words[1] == "ascii") {
    header.encoding = PlyHeader::Encoding::ascii;
  } else if (words[1] == "binary_little_endian") {
    header.encoding = PlyHeader::Encoding::little_endian;
  } else if (words[1] == "binary_big_endian") {
    header.encoding = PlyHeader::Encoding::big_endian;
  } else {
    return false;
  }
  return true;
}

bool add_element(const Words& words, PlyHeader& header) {
  if (words.size() != 3) return false;
  PlyElement element;
  element.name = words[1];
  const char* const end = words[2].data() + words[2].size();
  const auto parsed = std::from_chars(words[2].data(), end, element.count);
  if (parsed.ec != std::errc{} || parsed.ptr != end) return false;
  header.elements.push_back(std::move(element));
  return true;
}

bool add_property(const Words& words, PlyHeader& header) {
  if (header.elements.empty() || words.size() < 3) return false;
  PlyProperty property;
  property.is_list = words[1] == "list";
  if (words.size() != (property.is_list ? 5u : 3u)) return false;
  const auto type = type_of(words[words.size() - 2]);
  const auto count_type = property.is_list ? type_of(words[2]) : PlyType::uint8;
  if (!type || !count_type) return false;
  property.name = words.back();
  property.type = *type;
  property.count_type = *count_type;
  header.elements.back().properties.push_back(std::move(property));
  return true;
}

bool add_line(const Words& words, PlyHeader& header) {
  if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return true;
  if (words[0] == "format") return add_format(words, header);
  if (words[0] == "element") return add_element(words, header);
  return words[0] == "property" && add_property(words, header);
}

}  // namespace

std::size_t size_of(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::float64:
      return 8;
    default:
      return 4;
  }
}

Result<PlyHeader> parse_ply_header(std::string_view content) {
  const std::string_view text = content.substr(0, kLongestHeader);
  if (!text.starts_with("ply")) return fail("its content is not what its ending says");
  PlyHeader header;
  bool has_format = false;
  for (std::size_t start = 0; start < text.size();) {
    const auto end = text.find('\n', start);
    if (end == std::string_view::npos) break;
    const auto words = words_of(text.substr(start, end - start));
    start = end + 1;
    const bool first = start <= 5;
    if (first) continue;
    if (words.size() == 1 && words[0] == "end_header") {
      header.size = start;
      if (!has_format) return fail("its header names no format");
      return header;
    }
    has_format |= !words.empty() && words[0] == "format";
    if (!add_line(words, header)) {
      return fail(fmt::format("its header has a line that is no PLY: '{}'", fmt::join(words, " ")));
    }
  }
  return fail("its header has no end");
}

}  // namespace meshloop
