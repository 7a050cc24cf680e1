#pragma once
#include <cstddef>
#include <string>

namespace meshloop {

inline constexpr std::size_t kLongestName = 100;
inline constexpr std::size_t kLongestReason = 500;

/// Why a text cannot stand in one line of the journal, for people to read ("a name has no control characters"); empty
/// when it can. `what` is the subject ("a name"). Refused are bytes that are no UTF-8, texts of more than `longest`
/// letters, texts of blanks alone or with blanks at their ends (Unicode's too), and control characters, among them
/// those that break lines or turn the direction of writing.
[[nodiscard]] std::string why_not_one_line(const std::string& text, const std::string& what, std::size_t longest);

}  // namespace meshloop
