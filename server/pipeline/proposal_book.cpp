#include "server/pipeline/proposal_book.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "server/pipeline/proposal_match.h"

namespace meshloop {
namespace {

Result<std::vector<ProposalSighting>> match(const SceneStore& store, const std::vector<Proposal>& proposals) {
  const auto known = store.proposals();
  if (!known) return fail(known.error());
  std::vector<ProposalContent> contents;
  for (const auto& proposal : proposals) contents.push_back(content_of(proposal));
  return match_proposals(contents, *known);
}

/// `ids`: in the order of the proposals, 0 for none.
Result<std::vector<Offered>> offer(const SceneStore& store, std::vector<Proposal> proposals,
                                   const std::vector<ProposalId>& ids) {
  const auto records = store.proposals();
  if (!records) return fail(records.error());
  std::vector<Offered> offered;
  for (std::size_t i = 0; i < proposals.size(); ++i) {
    Offered& one = offered.emplace_back();
    const auto known =
        std::find_if(records->begin(), records->end(), [&](const auto& record) { return record.id == ids[i]; });
    if (known != records->end()) {
      one.record = *known;
    } else {
      one.record.content = content_of(proposals[i]);
    }
    one.proposal = std::move(proposals[i]);
    one.proposal.id = static_cast<RegionId>(one.record.id);
  }
  return offered;
}

}  // namespace

ProposalContent content_of(const Proposal& proposal) {
  ProposalContent content;
  content.kind = proposal.move                            ? ProposalKind::move
                 : proposal.kind == ChangeKind::insertion ? ProposalKind::insertion
                                                          : ProposalKind::removal;
  for (const auto& removal : proposal.removed) content.nodes.push_back(removal.node);
  if (proposal.move) {
    content.nodes.push_back(proposal.move->node);
    for (const auto& other : proposal.move->along) content.nodes.push_back(other.node);
    content.T_world_new_old = proposal.move->T_world_new_old;
  }
  content.box_m = proposal.box_m;
  content.effect = proposal.effect;
  content.confidence = proposal.confidence;
  content.largest_change_m = proposal.largest_change_m;
  return content;
}

Result<std::vector<Offered>> remember_proposals(SceneStore& store, std::vector<Proposal> proposals) {
  if (proposals.empty()) return std::vector<Offered>{};
  const auto sightings = match(store, proposals);
  if (!sightings) return fail(sightings.error());
  const auto ids = store.remember(*sightings);
  if (!ids) return fail(ids.error());
  return offer(store, std::move(proposals), *ids);
}

Result<std::vector<Offered>> recognise_proposals(const SceneStore& store, std::vector<Proposal> proposals) {
  const auto sightings = match(store, proposals);
  if (!sightings) return fail(sightings.error());
  std::vector<ProposalId> ids;
  for (const auto& sighting : *sightings) ids.push_back(sighting.known.value_or(0));
  return offer(store, std::move(proposals), ids);
}

ProposalRecord as_measured(const Offered& offered) {
  ProposalRecord record = offered.record;
  record.content = content_of(offered.proposal);
  return record;
}

std::string time_text(std::int64_t since_1970_ns) {
  const std::chrono::sys_seconds time{
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::nanoseconds{since_1970_ns})};
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", time);
}

std::string decision_text(const ProposalRecord& record) {
  const auto who = fmt::format("by {} at {}", record.author, time_text(record.decided_ns));
  switch (record.state) {
    case ProposalState::accepted:
      return fmt::format("proposal {} was accepted by revision {}, {}", record.id, *record.revision, who);
    case ProposalState::rejected:
      return fmt::format("proposal {} was rejected {}{}", record.id, who,
                         record.reason.empty() ? "" : ": " + record.reason);
    case ProposalState::open:
      break;
  }
  if (record.was_undone()) {
    return fmt::format("proposal {} is open again: revision {} was undone {}", record.id, *record.revision, who);
  }
  return fmt::format("proposal {} is open", record.id);
}

}  // namespace meshloop
