#pragma once
// Lines of numbers, as TUM files hold them. Private to this room.
#include <optional>
#include <string_view>
#include <vector>

namespace meshloop {

/// A line that says something: without comment lines, blank lines and surrounding blanks.
struct TextLine {
  int number = 0;
  std::string_view text;
};
[[nodiscard]] std::vector<TextLine> lines_of(std::string_view text);

/// Removes the first word of `rest`, and gives it; empty at the end.
[[nodiscard]] std::string_view take_word(std::string_view& rest, std::string_view separators = " \t");
/// The whole word as a finite number, whatever the locale.
[[nodiscard]] std::optional<double> number_of(std::string_view word);

}  // namespace meshloop
