#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace meshloop {

/// An event of the live station as a line for people; of one that this does not know its name.
[[nodiscard]] std::string event_text(const nlohmann::json& event);

}  // namespace meshloop
