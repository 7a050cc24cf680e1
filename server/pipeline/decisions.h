#pragma once
// What an operator decides of a snapshot's proposals, by their ids: `adjust --accept`, `--reject`.
#include <optional>
#include <string>
#include <vector>

#include "server/pipeline/proposal_book.h"

namespace meshloop {

/// Ids as `1,3-5` or `1, 3`, in growing order and each once. Refuses 0.
[[nodiscard]] Result<std::vector<ProposalId>> parse_proposal_ids(const std::string& text);

struct Decisions {
  /// What is open, those too that were accepted once and undone; not what was rejected.
  bool accept_all = false;
  /// What was rejected before can be accepted by its id.
  std::vector<ProposalId> accept;
  /// Those that are still to be rejected.
  std::vector<ProposalId> reject;
  std::string reason;
};

/// `all` or ids; an empty text for none. `option`: its name, for errors.
[[nodiscard]] Status parse_accept(const std::string& text, const std::string& option, Decisions& decisions);

/// Those that are accepted now. Refuses, with the reason, an id that the frame does not show: it is unknown, was
/// accepted already, or is open elsewhere.
[[nodiscard]] Result<std::vector<Offered>> chosen(const Decisions& decisions, const std::vector<Offered>& offered,
                                                  const std::vector<ProposalRecord>& known);

/// Rejects those that the scene knows, and takes them from the list; the others may turn up later. Refuses one that was
/// accepted.
[[nodiscard]] Status reject_known(SceneStore& store, const std::string& author, Decisions& decisions);
/// The same for a list that must all be known: why they cannot be rejected.
[[nodiscard]] std::optional<std::string> why_not_rejected(const std::vector<ProposalId>& ids,
                                                          const std::vector<ProposalRecord>& known);
/// The states that decisions made of them.
void refresh(const std::vector<ProposalRecord>& known, std::vector<Offered>& offered);
/// After all frames: an error when there is one that never turned up.
[[nodiscard]] Status check_all_rejected(const Decisions& decisions);

}  // namespace meshloop
