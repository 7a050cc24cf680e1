#include "server/pipeline/adjust_report.h"

#include <fmt/format.h>

#include "server/pipeline/proposal_json.h"

namespace meshloop {

nlohmann::json frame_json(const AdjustedFrame& frame) {
  nlohmann::json json = frame.details;
  json["index"] = frame.index;
  json["revision"] = nullptr;
  if (!frame.reason.empty()) json["reason"] = frame.reason;
  if (frame.revision) {
    json["revision"] = frame.revision->revision;
    json["triangles_added"] = frame.revision->triangles_added;
    json["triangles_removed"] = frame.revision->triangles_removed;
  }
  auto proposals = nlohmann::json::array();
  for (std::size_t i = 0; i < frame.offered.size(); ++i) {
    proposals.push_back(proposal_json(frame.offered[i]));
    if (i < frame.pictures.size()) proposals.back()["pictures"] = frame.pictures[i];
  }
  json["proposals"] = std::move(proposals);
  return json;
}

std::string frame_text(const AdjustedFrame& frame) {
  if (!frame.reason.empty()) return fmt::format("frame {}: {}\n", frame.index, frame.reason);
  const auto what = frame.revision ? fmt::format("revision {}", frame.revision->revision) : "nothing accepted";
  const auto count = frame.offered.size();
  auto text = fmt::format("frame {}: {}, {} proposal{}\n", frame.index, what, count, count == 1 ? "" : "s");
  for (const auto& offered : frame.offered) {
    text += proposal_line(as_measured(offered)) + '\n';
    if (offered.record.state == ProposalState::rejected)
      text += fmt::format("{:7}{}\n", "", decision_text(offered.record));
    const auto evidence = evidence_text(offered.proposal);
    if (!evidence.empty()) text += fmt::format("{:7}{}\n", "", evidence);
  }
  return text;
}

}  // namespace meshloop
