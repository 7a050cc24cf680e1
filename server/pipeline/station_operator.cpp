// The station and its operator: what is accepted by the rule, what is offered, and commands.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "common/base/clock.h"
#include "server/pipeline/proposal_json.h"
#include "server/pipeline/result_json.h"
#include "server/pipeline/station_parts.h"

namespace meshloop {
namespace {

/// Of the frames' own time. Proposing takes as long as a few frames.
constexpr double kLookAgain_s = 1;

std::vector<RegionId> confirmed_ids(const RegionMap& regions) {
  std::vector<RegionId> ids;
  for (const auto& region : regions.regions) {
    if (region.confirmed) ids.push_back(region.id);
  }
  return ids;
}

/// Why these cannot be accepted together.
std::optional<std::string> contradiction(const Model& model, const std::vector<Offered>& accepted) {
  std::vector<Proposal> proposals;
  for (const auto& offered : accepted) proposals.push_back(offered.proposal);
  const auto merged = merge_edits(model, proposals);
  return merged ? std::nullopt : std::optional{merged.error().message};
}

}  // namespace

bool Station::is_worth_a_look(const RegionMap& regions, double timestamp_s) const {
  const auto& looked = parts_->looked;
  return !looked || looked->regions != confirmed_ids(regions) || timestamp_s - looked->timestamp_s >= kLookAgain_s ||
         timestamp_s < looked->timestamp_s;
}

Status Station::consider(const TrackedFrame& tracked, Examination examination) {
  const bool has_rule = parts_->options.accept.what != AcceptanceRule::What::none;
  const double now_s = tracked.frame.depth_timestamp_s;
  if ((!has_rule && !parts_->options.commands) || !is_worth_a_look(examination.regions, now_s)) return {};
  auto offer = look(tracked, std::move(examination));
  if (!offer) return fail(offer.error());
  if (offer->proposals.empty()) return {};
  const auto accepted = chosen_by_rule(*offer);
  // An id that was told must not be given again, even when the power fails. Whoever waits for a change waits for no
  // disk.
  if (accepted.empty()) {
    if (auto synced = parts_->store->sync(); !synced) return fail("remembering proposals", synced.error());
  }
  if (accepted.size() < offer->proposals.size()) tell_proposals(*offer);
  if (!accepted.empty()) {
    parts_->offer.reset();
    return accept_by_rule(*offer, accepted);
  }
  parts_->looked = Looked{confirmed_ids(offer->examination.regions), now_s};
  if (!parts_->options.commands) return {};
  parts_->offered_regions = offer->examination.regions;
  parts_->offer = std::move(*offer);
  return {};
}

std::vector<Offered> Station::chosen_by_rule(const Offer& offer) const {
  std::vector<Offered> accepted;
  for (const auto& one : offer.proposals) {
    if (!why_left_out(parts_->options.accept, one.record)) accepted.push_back(one);
  }
  return accepted;
}

void Station::tell_proposals(const Offer& offer) const {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& one : offer.proposals) {
    const auto reason = why_left_out(parts_->options.accept, one.record);
    list.push_back(proposal_json(one));
    list.back()["left_out"] = reason ? nlohmann::json(*reason) : nlohmann::json(nullptr);
  }
  tell({{"event", "proposals"}, {"frame", offer.tracked.frame.index}, {"proposals", list}});
  if (parts_->options.json) return;
  for (const auto& one : offer.proposals) std::cout << proposal_line(as_measured(one)) << std::endl;
}

Status Station::offer_again() {
  if (!parts_->offer) return {};
  const TrackedFrame tracked = std::move(parts_->offer->tracked);
  parts_->offer.reset();
  auto examined = parts_->examiner.examine_again(tracked, *parts_->store->model(), parts_->offered_regions);
  if (!examined) return fail(fmt::format("frame {}", tracked.frame.index), examined.error());
  auto offer = look(tracked, std::move(*examined));
  if (!offer) return fail(offer.error());
  if (auto synced = parts_->store->sync(); !synced) return fail("remembering proposals", synced.error());
  tell_proposals(*offer);
  parts_->offer = std::move(*offer);
  return {};
}

Status Station::obey_all() {
  const bool was_open = !parts_->commands.ended();
  for (const auto& line : parts_->commands.read()) {
    auto command = parse_command(line);
    Result<Refusal> done = command ? obey(std::move(*command)) : Result<Refusal>{command.error().message};
    if (!done) return fail(fmt::format("'{}'", line), done.error());
    const nlohmann::json refused = *done ? nlohmann::json(**done) : nlohmann::json(nullptr);
    tell({{"event", "command"},
          {"command", line},
          {"refused", refused},
          {"revision", parts_->store->model()->revision}});
  }
  if (was_open && parts_->commands.ended()) tell({{"event", "commands_ended"}});
  return {};
}

Result<Station::Refusal> Station::obey(OperatorCommand command) {
  switch (command.what) {
    case OperatorCommand::What::accept:
      return accept_as_told(command);
    case OperatorCommand::What::reject:
      return reject_as_told(std::move(command));
    case OperatorCommand::What::undo:
      return go_back_or_forth(true);
    case OperatorCommand::What::redo:
      return go_back_or_forth(false);
    case OperatorCommand::What::list:
      break;
  }
  if (!parts_->offer) return Refusal{"nothing is proposed now"};
  tell_proposals(*parts_->offer);
  return Refusal{};
}

Result<Station::Refusal> Station::accept_as_told(const OperatorCommand& command) {
  if (!parts_->offer) return Refusal{"nothing is proposed now"};
  const auto known = parts_->store->proposals();
  if (!known) return fail(known.error());
  const auto accepted = chosen(command.decisions, parts_->offer->proposals, *known);
  if (!accepted) return Refusal{accepted.error().message};
  if (accepted->empty()) return Refusal{"nothing that is proposed is open"};
  if (auto why = contradiction(*parts_->store->model(), *accepted)) return why;
  if (auto done = accept(*parts_->offer, *accepted, parts_->options.operator_name); !done) return fail(done.error());
  if (auto done = offer_again(); !done) return fail(done.error());
  return Refusal{};
}

Result<Station::Refusal> Station::reject_as_told(OperatorCommand command) {
  const auto wanted = command.decisions.reject;
  const auto known = parts_->store->proposals();
  if (!known) return fail(known.error());
  if (auto why = why_not_rejected(wanted, *known)) return why;
  if (auto done = reject_known(*parts_->store, parts_->options.operator_name, command.decisions); !done) {
    return fail(done.error());
  }
  if (!parts_->offer) return Refusal{};
  const auto now = parts_->store->proposals();
  if (!now) return fail(now.error());
  refresh(*now, parts_->offer->proposals);
  return Refusal{};
}

Result<Station::Refusal> Station::go_back_or_forth(bool back) {
  auto& store = *parts_->store;
  const auto& author = parts_->options.operator_name;
  const auto model = back ? store.undo(author) : store.redo(author);
  if (!model) return Refusal{model.error().message};
  const auto now_ns = wall_clock_ns();
  publish_or_retry(now_ns);
  parts_->examiner.model_changed();
  parts_->looked.reset();
  tell({{"event", "revision"},
        {"revision", (*model)->revision},
        {"frame", nullptr},
        {"accepted_ns", now_ns},
        {"triangles", (*model)->triangle_count()},
        {"published", !parts_->unpublished_ns},
        {"bytes", parts_->last_publish.bytes},
        {"raw_bytes", parts_->last_publish.raw_bytes},
        {"devices", parts_->publisher.readers()},
        {"summary", back ? "undo" : "redo"}});
  if (auto done = offer_again(); !done) return fail(done.error());
  return Refusal{};
}

}  // namespace meshloop
