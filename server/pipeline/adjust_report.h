#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "server/pipeline/proposal_book.h"

namespace meshloop {

/// What `adjust` did with one frame.
struct AdjustedFrame {
  int index = 0;
  /// Why nothing is proposed; empty when something could be.
  std::string reason;
  std::vector<Offered> offered;
  /// Of those that were accepted.
  std::optional<RevisionInfo> revision;
  /// By the position in `offered`: files in --out; null for what has no id.
  std::vector<nlohmann::json> pictures;
  /// Times, registration, fusion.
  nlohmann::json details = nlohmann::json::object();
};

[[nodiscard]] nlohmann::json frame_json(const AdjustedFrame& frame);
/// Lines for people.
[[nodiscard]] std::string frame_text(const AdjustedFrame& frame);

}  // namespace meshloop
