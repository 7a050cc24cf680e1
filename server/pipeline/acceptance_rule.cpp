#include "server/pipeline/acceptance_rule.h"

#include <fmt/format.h>

namespace meshloop {

std::optional<std::string> why_left_out(const AcceptanceRule& rule, const ProposalRecord& record) {
  if (record.state == ProposalState::rejected) {
    return fmt::format("rejected by {}{}", record.author, record.reason.empty() ? "" : ": " + record.reason);
  }
  if (record.state == ProposalState::accepted) return "accepted already";
  if (record.was_undone()) return fmt::format("undone by {}", record.author);
  if (rule.what == AcceptanceRule::What::none) return "nothing is accepted without asking";
  if (rule.what == AcceptanceRule::What::all) return std::nullopt;
  const ProposalContent& content = record.content;
  if (!(content.confidence >= rule.least_confidence)) {
    return fmt::format("its confidence is {:.3f}, below {:.3f}", content.confidence, rule.least_confidence);
  }
  if (!(content.largest_change_m > 0)) return "how large its change is cannot be told: the model had nothing there";
  if (!(content.largest_change_m <= rule.largest_change_m)) {
    return fmt::format("it changes {:.0f} mm, more than {:.0f}", 1000 * content.largest_change_m,
                       1000 * rule.largest_change_m);
  }
  return std::nullopt;
}

}  // namespace meshloop
