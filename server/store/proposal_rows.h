#pragma once
// The tables `proposal` and `accepted_proposal`. The scene must have them (has_proposals); what changes is done in a
// transaction of the caller's.
#include <vector>

#include "server/store/proposal_record.h"
#include "server/store/sqlite.h"

namespace meshloop {

/// Of all states, by id. What comes from the file is checked.
[[nodiscard]] Result<std::vector<ProposalRecord>> read_proposals(Database& database);

/// Ids in the order of the sightings. A known open one takes the sighting's content, a known rejected one keeps its
/// own; refuses an id that is not there or was accepted, and a box that is empty or not finite.
[[nodiscard]] Result<std::vector<ProposalId>> remember_proposals(Database& database,
                                                                 const std::vector<ProposalSighting>& seen,
                                                                 std::int64_t now_ns);

/// Refuses ids that are not there or were accepted; then none is rejected.
[[nodiscard]] Status reject_proposals(Database& database, const std::vector<ProposalId>& ids, const std::string& author,
                                      const std::string& reason, std::int64_t now_ns);

/// The proposals become accepted ones of the revision, which must be in the journal. Refuses as reject_proposals does.
[[nodiscard]] Status accept_proposals(Database& database, Revision revision, const std::string& author,
                                      std::int64_t now_ns, const std::vector<AcceptedProposal>& accepted);

/// What this revision accepted is open again, as this author decided.
[[nodiscard]] Status reopen_proposals(Database& database, Revision revision, const std::string& author,
                                      std::int64_t now_ns);
/// What this revision accepted is accepted again, as its author decided when it was made: who did the redo stands in
/// the journal. Refused where one was rejected since.
[[nodiscard]] Status close_proposals_again(Database& database, Revision revision);

/// Of one revision, by id.
[[nodiscard]] Result<std::vector<AcceptedProposal>> read_accepted(Database& database, Revision revision);

}  // namespace meshloop
