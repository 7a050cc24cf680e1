#include "server/pipeline/decisions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "common/program/arguments.h"

namespace meshloop {
namespace {

const ProposalRecord* find(const std::vector<ProposalRecord>& records, ProposalId id) {
  const auto found = std::find_if(records.begin(), records.end(), [&](const auto& record) { return record.id == id; });
  return found == records.end() ? nullptr : &*found;
}

bool has(const std::vector<ProposalId>& ids, ProposalId id) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

Error not_there(ProposalId id, const std::vector<Offered>& offered, const std::vector<ProposalRecord>& known) {
  std::vector<ProposalId> there;
  for (const auto& one : offered) there.push_back(one.record.id);
  std::sort(there.begin(), there.end());
  const auto frame_has = there.empty() ? std::string{"the frame proposes nothing"}
                                       : fmt::format("the frame has {}", fmt::join(there, ", "));
  const ProposalRecord* record = find(known, id);
  std::string what = fmt::format("there is no proposal {}", id);
  if (record != nullptr && record->state == ProposalState::accepted) {
    what = decision_text(*record) + ", and cannot be accepted again";
  } else if (record != nullptr) {
    what = fmt::format("proposal {} is not seen here (last seen {})", id, time_text(record->last_seen_ns));
  }
  return {ErrorKind::failed, fmt::format("{}; {}", what, frame_has)};
}

/// "1, 3" as "1,3"; "1 3" stays what it is.
std::string without_blanks_at_commas(const std::string& text) {
  std::string result;
  for (std::size_t begin = 0; begin <= text.size();) {
    const auto end = std::min(text.find(',', begin), text.size());
    const auto first = std::min(text.find_first_not_of(" \t", begin), end);
    const auto past = text.find_last_not_of(" \t", end - (end > begin ? 1 : 0)) + 1;
    if (first < end) result += text.substr(first, past - first);
    if (end < text.size()) result += ',';
    begin = end + 1;
  }
  return result;
}

}  // namespace

Result<std::vector<ProposalId>> parse_proposal_ids(const std::string& text) {
  const auto numbers = parse_frame_list(without_blanks_at_commas(text));
  if (!numbers) return fail(fmt::format("'{}' is no list of ids such as 1,3", text), ErrorKind::usage);
  if (numbers->front() == 0) return fail("ids of proposals begin with 1", ErrorKind::usage);
  return std::vector<ProposalId>(numbers->begin(), numbers->end());
}

Status parse_accept(const std::string& text, const std::string& option, Decisions& decisions) {
  decisions.accept_all = text == "all";
  if (decisions.accept_all || text.empty()) return {};
  auto ids = parse_proposal_ids(text);
  if (!ids) return fail(fmt::format("{} takes all, or ids such as 1,3, not '{}'", option, text), ErrorKind::usage);
  decisions.accept = std::move(*ids);
  return {};
}

Result<std::vector<Offered>> chosen(const Decisions& decisions, const std::vector<Offered>& offered,
                                    const std::vector<ProposalRecord>& known) {
  std::vector<Offered> accepted;
  std::vector<ProposalId> missing = decisions.accept;
  for (const auto& one : offered) {
    const bool is_named = has(decisions.accept, one.record.id);
    if (is_named) std::erase(missing, one.record.id);
    if (is_named || (decisions.accept_all && one.record.state == ProposalState::open)) accepted.push_back(one);
  }
  if (!missing.empty()) return fail(not_there(missing.front(), offered, known));
  return accepted;
}

Status reject_known(SceneStore& store, const std::string& author, Decisions& decisions) {
  if (decisions.reject.empty()) return {};
  const auto known = store.proposals();
  if (!known) return fail(known.error());
  std::vector<ProposalId> there;
  for (const auto id : decisions.reject) {
    const ProposalRecord* record = find(*known, id);
    if (record == nullptr) continue;
    if (record->state == ProposalState::accepted) {
      return fail(fmt::format("{}; `scene undo` takes the last revision back", decision_text(*record)));
    }
    there.push_back(id);
  }
  if (there.empty()) return {};
  if (auto done = store.reject(there, author, decisions.reason); !done) return done;
  std::erase_if(decisions.reject, [&](ProposalId id) { return has(there, id); });
  return {};
}

std::optional<std::string> why_not_rejected(const std::vector<ProposalId>& ids,
                                            const std::vector<ProposalRecord>& known) {
  for (const auto id : ids) {
    const ProposalRecord* record = find(known, id);
    if (record == nullptr) return fmt::format("there is no proposal {}", id);
    if (record->state == ProposalState::accepted) return decision_text(*record);
  }
  return std::nullopt;
}

void refresh(const std::vector<ProposalRecord>& known, std::vector<Offered>& offered) {
  for (auto& one : offered) {
    if (const auto* record = find(known, one.record.id)) one.record = *record;
  }
}

Status check_all_rejected(const Decisions& decisions) {
  if (decisions.reject.empty()) return {};
  return fail(fmt::format("there is no proposal {} to reject; `scene proposals` lists them", decisions.reject.front()));
}

}  // namespace meshloop
