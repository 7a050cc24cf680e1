#include "common/program/arguments.h"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <set>
#include <sstream>

namespace meshloop {
namespace {

constexpr int kMaxFrame = 1'000'000;

std::optional<int> parse_number(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < 0 || number > kMaxFrame) return std::nullopt;
  return number;
}

}  // namespace

Result<std::vector<int>> parse_frame_list(const std::string& text) {
  std::set<int> frames;
  // A comma at the end begins one more part, which getline does not give.
  std::istringstream parts{text.ends_with(',') ? text + ',' : text};
  for (std::string part; std::getline(parts, part, ',');) {
    const auto dash = part.find('-');
    const auto first = parse_number(part.substr(0, dash));
    const auto last = dash == std::string::npos ? first : parse_number(part.substr(dash + 1));
    if (!first || !last || *last < *first) {
      return fail(fmt::format("'{}' is not a list of frames such as 0,5,10-20", text), ErrorKind::usage);
    }
    for (int frame = *first; frame <= *last; ++frame) frames.insert(frame);
  }
  if (frames.empty()) return fail("the list of frames is empty", ErrorKind::usage);
  return std::vector<int>(frames.begin(), frames.end());
}

CLI::Validator between(double smallest, double largest) {
  const auto check = [smallest, largest](const std::string& text) -> std::string {
    double value = 0;
    if (CLI::detail::lexical_cast(text, value) && value >= smallest && value <= largest) return {};
    return fmt::format("{} is not between {} and {}", text, smallest, largest);
  };
  return {check, fmt::format("FLOAT in [{} - {}]", smallest, largest)};
}

CLI::Validator counter() {
  const auto check = [](const std::string& text) -> std::string {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc{} && end == text.data() + text.size();
    return whole && value >= 0 ? std::string{} : fmt::format("{} is not a whole number from 0 on", text);
  };
  return {check, "UINT"};
}

KindAndRest split_kind(const std::string& text) {
  const auto colon = text.find(':');
  if (colon == std::string::npos) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

}  // namespace meshloop
