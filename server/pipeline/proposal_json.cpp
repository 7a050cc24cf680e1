#include "server/pipeline/proposal_json.h"

#include <fmt/format.h>

#include "server/pipeline/result_json.h"

namespace meshloop {
namespace {

nlohmann::json content_json(const ProposalContent& content) {
  const Eigen::Vector3d centre = content.box_m.center();
  return {{"kind", name_of(content.kind)},
          {"nodes", content.nodes},
          {"centre_m", std::vector(centre.begin(), centre.end())},
          {"box_m", box_json(content.box_m)},
          {"effect", content.effect},
          {"confidence", content.confidence},
          {"largest_change_m", content.largest_change_m},
          {"T_world_new_old", content.T_world_new_old ? pose_json(*content.T_world_new_old) : nlohmann::json(nullptr)}};
}

template <class T>
nlohmann::json or_null(bool is_there, const T& value) {
  return is_there ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json see_through_json(const SeeThrough& seen) {
  return {{"share", seen.share()},        {"visible_px", seen.visible},
          {"measured_px", seen.measured}, {"seen_through_px", seen.seen_through},
          {"behind_m", seen.behind_m},    {"behind_sigmas", seen.behind_sigmas}};
}

}  // namespace

nlohmann::json proposal_json(const ProposalRecord& record) {
  auto json = content_json(record.content);
  const bool is_accepted = record.state == ProposalState::accepted;
  const bool is_decided = !record.author.empty();
  json["id"] = or_null(record.id != 0, record.id);
  json["state"] = name_of(record.state);
  json["accepted"] = is_accepted;
  json["revision"] = or_null(is_accepted, record.revision.value_or(0));
  json["undone_revision"] = or_null(record.was_undone(), record.revision.value_or(0));
  json["first_seen_ns"] = or_null(record.id != 0, record.first_seen_ns);
  json["last_seen_ns"] = or_null(record.id != 0, record.last_seen_ns);
  json["author"] = or_null(is_decided, record.author);
  json["decided_ns"] = or_null(is_decided, record.decided_ns);
  json["reason"] = or_null(!record.reason.empty(), record.reason);
  return json;
}

nlohmann::json proposal_json(const Offered& offered) {
  auto json = proposal_json(as_measured(offered));
  const Proposal& proposal = offered.proposal;
  json["triangles_added"] = proposal.triangles_added;
  json["triangles_removed"] = proposal.triangles_removed;
  json["closes"] = proposal.closes;
  json["see_through"] = proposal.see_through ? see_through_json(*proposal.see_through) : nlohmann::json(nullptr);
  if (proposal.move) json["move"] = move_json(*proposal.move);
  return json;
}

nlohmann::json proposal_json(const AcceptedProposal& accepted) {
  auto json = content_json(accepted.content);
  json["id"] = accepted.id;
  return json;
}

std::string proposal_line(const ProposalRecord& record) {
  const auto& content = record.content;
  const Eigen::Vector3d centre = content.box_m.center();
  const Eigen::Vector3d size = content.box_m.sizes();
  return fmt::format(
      "{:>5}  {:<9}  {:<8}  {}; at ({:.2f}, {:.2f}, {:.2f}), {:.2f} x {:.2f} x {:.2f} m; confidence {:.2f}",
      record.id == 0 ? "-" : std::to_string(record.id), name_of(content.kind), name_of(record.state), content.effect,
      centre.x(), centre.y(), centre.z(), size.x(), size.y(), size.z(), content.confidence);
}

std::string evidence_text(const Proposal& proposal) {
  if (!proposal.see_through) return {};
  const SeeThrough& seen = *proposal.see_through;
  return fmt::format("seen through at {:.0f} % of {} pixels, by {:.0f} mm ({:.0f} sigma)", 100 * seen.share(),
                     seen.visible, 1000 * seen.behind_m, seen.behind_sigmas);
}

}  // namespace meshloop
