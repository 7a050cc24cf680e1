// The station and its operator: what is accepted by the rule, what is offered, and commands.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "common/base/clock.h"
#include "server/pipeline/proposal_json.h"
#include "server/pipeline/result_json.h"
#include "server/pipeline/scene_history.h"
#include "server/pipeline/station_parts.h"

namespace meshloop {
namespace {

constexpr const char* kWouldEmpty =
    "that would take the whole model from all devices; to do so, end the station and use `scene undo`, or `scene "
    "restore REVISION`";

/// Of the frames' own time. Proposing takes as long as a few frames.
constexpr double kLookAgain_s = 1;

std::vector<RegionId> confirmed_ids(const RegionMap& regions) {
  std::vector<RegionId> ids;
  for (const auto& region : regions.regions) {
    if (region.confirmed) ids.push_back(region.id);
  }
  return ids;
}

std::optional<std::string> reason_of(const std::optional<PoseObjection>& objection) {
  return objection ? std::optional{objection->reason} : std::nullopt;
}

/// Why these cannot be accepted together.
std::optional<std::string> contradiction(const Model& model, const std::vector<Offered>& accepted) {
  std::vector<Proposal> proposals;
  for (const auto& offered : accepted) proposals.push_back(offered.proposal);
  const auto merged = merge_edits(model, proposals);
  return merged ? std::nullopt : std::optional{merged.error().message};
}

}  // namespace

Station::Fusable Station::fusable_with(const TrackedFrame& tracked, const RegionMap& regions) const {
  return {parts_->recent, first_frame_of(regions, tracked.frame.index)};
}

Result<Station::Offer> Station::look(TrackedFrame tracked, Examination examination, Fusable fusable, Turn turn) {
  const Stopwatch watch;
  const int frame = tracked.frame.index;
  auto changes = propose_changes(tracked, examination, fusable.recent.before(tracked, fusable.first), parts_->rig,
                                 *parts_->store, parts_->options.adjust);
  Offer offer{.tracked = std::move(tracked),
              .examination = std::move(examination),
              .registration = changes.registration,
              .rings = changes.rings,
              .joint = changes.joint,
              .fusable = std::move(fusable),
              .withheld = turn == Turn::first ? count_withheld(frame, changes.withheld, !changes.proposals.empty())
                                              : reason_of(changes.withheld),
              .frames = changes.frames,
              .snapshot_ms = watch.milliseconds(),
              .proposals = {}};
  if (offer.withheld) {
    tell_withheld(offer.tracked, *offer.withheld, offer.registration, offer.rings);
    return offer;
  }
  auto proposals = remember_proposals(*parts_->store, std::move(changes.proposals));
  if (!proposals) return fail("remembering proposals", proposals.error());
  offer.proposals = std::move(*proposals);
  return offer;
}

void Station::tell_withheld(const TrackedFrame& tracked, const std::string& reason, const Registration& registration,
                            const EdgeRings& rings) const {
  tell({{"event", "withheld"},
        {"frame", tracked.frame.index},
        {"reason", reason},
        {"registration", registration_json(registration, tracked.depth_pose)},
        {"edge_rings", rings_json(rings)}});
}

std::optional<std::string> Station::count_withheld(int frame, const std::optional<PoseObjection>& objection,
                                                   bool speaks_for_poses) {
  if (objection) {
    parts_->trust.lose();
    parts_->recent.clear();  // the frames before passed no gate
    parts_->tally.add_withheld(frame, *objection);
    return objection->reason;
  }
  auto doubt = speaks_for_poses ? parts_->trust.regain() : std::nullopt;
  doubt ? parts_->tally.add_distrusted() : parts_->tally.add_usable();
  return doubt;
}

bool Station::is_worth_a_look(const RegionMap& regions, double timestamp_s) const {
  const auto& looked = parts_->looked;
  return !looked || looked->regions != confirmed_ids(regions) || timestamp_s - looked->timestamp_s >= kLookAgain_s ||
         timestamp_s < looked->timestamp_s;
}

Status Station::consider(const TrackedFrame& tracked, Examination examination) {
  const bool has_rule = parts_->options.accept.what != AcceptanceRule::What::none;
  const double now_s = tracked.frame.depth_timestamp_s;
  if (!has_rule && !parts_->options.commands) {
    watch_pose(tracked, examination);
    return {};
  }
  if (!is_worth_a_look(examination.regions, now_s)) return {};
  auto fusable = fusable_with(tracked, examination.regions);
  auto offer = look(tracked, std::move(examination), std::move(fusable), Turn::first);
  if (!offer) return fail(offer.error());
  if (offer->withheld) return {};
  parts_->looked = Looked{confirmed_ids(offer->examination.regions), now_s};
  if (offer->proposals.empty()) return {};
  const auto accepted = chosen_by_rule(*offer);
  // Whoever waits for a change waits for no disk.
  if (!accepted.empty()) return accept_by_rule(std::move(*offer), accepted);
  // An id that was told must not be given again, even when the power fails.
  if (auto synced = parts_->store->sync(); !synced) return fail("remembering proposals", synced.error());
  tell_proposals(*offer);
  if (!parts_->options.commands) return {};
  parts_->offered_regions = offer->examination.regions;
  parts_->offer = std::move(*offer);
  return {};
}

void Station::watch_pose(const TrackedFrame& tracked, const Examination& examination) {
  const double now_s = tracked.frame.depth_timestamp_s;
  const auto& looked = parts_->looked;
  if (looked && now_s >= looked->timestamp_s && now_s - looked->timestamp_s < kLookAgain_s) return;
  parts_->looked = Looked{{}, now_s};
  const auto check = check_pose(tracked, examination, parts_->rig, *parts_->store->model());
  // Nothing waits for the poses to be trusted again here.
  const auto withheld = count_withheld(tracked.frame.index, check.objection, false);
  if (withheld) tell_withheld(tracked, *withheld, check.registration, check.rings);
}

Status Station::accept_by_rule(Offer offer, const std::vector<Offered>& accepted) {
  parts_->offer.reset();
  const auto author = parts_->options.operator_name + " (automatic)";
  auto first = change(offer, accepted, author);
  if (!first) return fail(first.error());
  std::vector<Change> changes;
  changes.push_back(std::move(*first));
  Status second_done;
  std::optional<Offer> behind;
  if (changes.front().acceptance.info.triangles_removed > 0 || !changes.front().acceptance.moves.empty()) {
    auto second = change_behind(offer, author, behind);
    if (!second) second_done = fail(second.error());  // the first one stays, and is told
    if (second && *second) changes.push_back(std::move(**second));
  }
  if (auto concluded = conclude(changes); !concluded) return concluded;
  if (!second_done) return second_done;
  return tell_left_out(std::move(offer), std::move(behind));
}

Result<std::optional<Station::Change>> Station::change_behind(const Offer& offer, const std::string& author,
                                                              std::optional<Offer>& behind) {
  const TrackedFrame& tracked = offer.tracked;
  auto examined = parts_->examiner.examine_behind(tracked, *parts_->store->model(), offer.examination.regions);
  if (!examined) return fail(fmt::format("frame {}", tracked.frame.index), examined.error());
  auto& regions = examined->regions.regions;
  for (auto& region : regions) region.confirmed = region.confirmed && region.kind == ChangeKind::insertion;
  auto fusable = fusable_with(tracked, examined->regions);
  auto looked = look(tracked, std::move(*examined), std::move(fusable), Turn::again);
  if (!looked) return fail(looked.error());
  behind = std::move(*looked);
  const auto accepted = chosen_by_rule(*behind);
  if (accepted.empty()) return std::nullopt;
  auto done = change(*behind, accepted, author);
  if (!done) return fail(done.error());
  return std::move(*done);
}

Status Station::tell_left_out(Offer offer, std::optional<Offer> behind) {
  const auto known = parts_->store->proposals();
  if (!known) return fail(known.error());
  const auto keep_left_out = [&](Offer& told) {
    refresh(*known, told.proposals);
    std::erase_if(told.proposals, [](const Offered& one) { return one.record.state == ProposalState::accepted; });
    return !told.proposals.empty();
  };
  const bool is_left = keep_left_out(offer);
  const bool is_left_behind = behind && keep_left_out(*behind);
  if (!is_left && !is_left_behind) return {};
  if (parts_->options.commands) {
    parts_->offered_regions = offer.examination.regions;
    parts_->offer = std::move(offer);
    return offer_again();
  }
  if (is_left) tell_proposals(offer);
  if (is_left_behind) tell_proposals(*behind);
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
  Fusable fusable = std::move(parts_->offer->fusable);  // its regions have been there since, whatever was accepted
  parts_->offer.reset();
  auto examined = parts_->examiner.examine_again(tracked, *parts_->store->model(), parts_->offered_regions);
  if (!examined) return fail(fmt::format("frame {}", tracked.frame.index), examined.error());
  auto offer = look(tracked, std::move(*examined), std::move(fusable), Turn::again);
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
  if (!parts_->offer) return Refusal{parts_->trust.why_nothing_is_proposed()};
  tell_proposals(*parts_->offer);
  return Refusal{};
}

Result<Station::Refusal> Station::accept_as_told(const OperatorCommand& command) {
  if (!parts_->offer) return Refusal{parts_->trust.why_nothing_is_proposed()};
  if (const auto doubt = parts_->trust.doubt()) return Refusal{*doubt + "; accept it when they have"};
  const auto known = parts_->store->proposals();
  if (!known) return fail(known.error());
  const auto accepted = chosen(command.decisions, parts_->offer->proposals, *known);
  if (!accepted) return Refusal{accepted.error().message};
  if (accepted->empty()) return Refusal{parts_->offer->withheld.value_or("nothing that is proposed is open")};
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
  const auto empties = would_empty(store, back);
  if (!empties) return fail(empties.error());
  if (*empties) return Refusal{kWouldEmpty};
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
