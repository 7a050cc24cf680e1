#pragma once
// What is accepted without asking. Pure.
#include <optional>
#include <string>

#include "server/store/proposal_record.h"

namespace meshloop {

struct AcceptanceRule {
  enum class What { none, all, sure };
  What what = What::none;
  /// For `sure`: at least this confidence, and at most this change.
  double least_confidence = 0.9;
  double largest_change_m = 0.3;
};

/// Why a proposal is not accepted without asking, or nothing when it is. What somebody rejected, or took back by undo,
/// never is. A change of 0 (the model had nothing to measure it against) is not known to be small.
[[nodiscard]] std::optional<std::string> why_left_out(const AcceptanceRule& rule, const ProposalRecord& record);

}  // namespace meshloop
