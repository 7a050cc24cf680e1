#include "server/pipeline/operator_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

namespace meshloop {
namespace {

/// Bytes of the letter that begins with this one; 0 for none.
std::size_t length_from(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first < 0xe0) return 2;
  if (first >= 0xe0 && first < 0xf0) return 3;
  if (first >= 0xf0 && first < 0xf5) return 4;
  return 0;
}

/// Code points, nothing where the bytes are no UTF-8 (RFC 3629: shortest form, no surrogates, up to U+10FFFF).
std::optional<std::vector<char32_t>> decode(const std::string& text) {
  constexpr char32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  std::vector<char32_t> letters;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = length_from(first);
    if (length == 0 || i + length > text.size()) return std::nullopt;
    char32_t letter = length == 1 ? first : first & (0x7fU >> length);
    for (std::size_t k = 1; k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      if ((next & 0xc0U) != 0x80U) return std::nullopt;
      letter = letter << 6 | (next & 0x3fU);
    }
    if (letter < kSmallest[length] || letter > 0x10ffff || (letter >= 0xd800 && letter < 0xe000)) return std::nullopt;
    letters.push_back(letter);
    i += length;
  }
  return letters;
}

bool is_control(char32_t c) {
  const bool breaks_lines = c == 0x2028 || c == 0x2029;
  const bool turns_writing =
      c == 0x061c || c == 0x200e || c == 0x200f || (c >= 0x202a && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || breaks_lines || turns_writing || c == 0xfeff;
}

bool is_blank(char32_t c) {
  return c == 0x20 || c == 0xa0 || c == 0x1680 || (c >= 0x2000 && c <= 0x200b) || c == 0x202f || c == 0x205f ||
         c == 0x3000;
}

}  // namespace

std::string why_not_one_line(const std::string& text, const std::string& what, std::size_t longest) {
  const auto letters = decode(text);
  if (!letters) return what + " must be UTF-8";
  if (std::any_of(letters->begin(), letters->end(), is_control)) return what + " has no control characters";
  if (std::all_of(letters->begin(), letters->end(), is_blank)) return what + " needs more than blanks";
  if (is_blank(letters->front()) || is_blank(letters->back())) return what + " has no blanks at its ends";
  if (letters->size() > longest) {
    return fmt::format("{} has at most {} letters, not {}", what, longest, letters->size());
  }
  return {};
}

}  // namespace meshloop
