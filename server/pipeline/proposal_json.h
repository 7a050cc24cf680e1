#pragma once
// Proposals as JSON and as lines of text. The keys are a contract: keys are added, never renamed.
#include <nlohmann/json.hpp>
#include <string>

#include "server/pipeline/proposal_book.h"

namespace meshloop {

/// Id (null: not kept), kind, state, place, effect, confidence, who decided, when and why.
[[nodiscard]] nlohmann::json proposal_json(const ProposalRecord& record);
/// Further what only the snapshot knows: triangles, regions, the evidence of a removal, all of a move.
[[nodiscard]] nlohmann::json proposal_json(const Offered& offered);
/// As the journal has it.
[[nodiscard]] nlohmann::json proposal_json(const AcceptedProposal& accepted);

/// "  3  removal    open      -312 triangles; ...; at (0.10, 0.20, 0.30), 0.30 x 0.20 x 0.10 m"
[[nodiscard]] std::string proposal_line(const ProposalRecord& record);
/// "seen through at 97 % of 1234 pixels, by 120 mm (40 sigma)"; empty where there is no removal.
[[nodiscard]] std::string evidence_text(const Proposal& proposal);

}  // namespace meshloop
