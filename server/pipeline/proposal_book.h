#pragma once
// Proposals of a snapshot under the ids that the scene keeps: adjust and store, joined.
#include <string>
#include <vector>

#include "server/adjust/proposal.h"
#include "server/store/scene_store.h"

namespace meshloop {

/// A proposal of a snapshot, and what the scene knows of it.
struct Offered {
  /// Its id is the record's: what reads it from here on speaks to people.
  Proposal proposal;
  /// Id 0 where the scene could not be told of a new one.
  ProposalRecord record;
};

[[nodiscard]] ProposalContent content_of(const Proposal& proposal);

/// Finds the known ones (proposal_match.h) and remembers all, without waiting for the disk. In their order.
[[nodiscard]] Result<std::vector<Offered>> remember_proposals(SceneStore& store, std::vector<Proposal> proposals);
/// The same for a scene that cannot be written: what is new has no id.
[[nodiscard]] Result<std::vector<Offered>> recognise_proposals(const SceneStore& store,
                                                               std::vector<Proposal> proposals);

/// The record with what was just measured; a rejected one keeps what was rejected.
[[nodiscard]] ProposalRecord as_measured(const Offered& offered);

/// "proposal 3 was accepted by revision 4, by anna at 2026-11-23T14:48:00Z", "... was rejected by anna at ...: noise"
[[nodiscard]] std::string decision_text(const ProposalRecord& record);
/// UTC, to the second.
[[nodiscard]] std::string time_text(std::int64_t since_1970_ns);

}  // namespace meshloop
