#pragma once
#include <string>
#include <string_view>

namespace meshloop {

/// The text as a JSON string with its quotation marks. Bytes that are not UTF-8 become question marks.
[[nodiscard]] std::string json_string(std::string_view text);

}  // namespace meshloop
