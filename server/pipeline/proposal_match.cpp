#include "server/pipeline/proposal_match.h"

#include <algorithm>
#include <tuple>

namespace meshloop {
namespace {

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kBoxMargin_m);
  return {box.min() - margin, box.max() + margin};
}

/// Their common volume as a share of what they cover together: 1 for the same box.
double likeness(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  const double common = grown(a).intersection(grown(b)).volume();
  return common / (grown(a).volume() + grown(b).volume() - common);
}

bool is_too_small_for(const ProposalRecord& record, const Eigen::AlignedBox3d& seen) {
  return record.state == ProposalState::rejected &&
         kMostTimesSmallerOfRejected * grown(seen).volume() < grown(record.content.box_m).volume();
}

struct Pair {
  double likeness = 0;
  std::size_t content = 0;
  const ProposalRecord* record = nullptr;
};

std::vector<Pair> possible_pairs(const std::vector<ProposalContent>& contents,
                                 const std::vector<ProposalRecord>& known) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    for (const auto& record : known) {
      if (record.state == ProposalState::accepted || record.content.kind != contents[i].kind) continue;
      const auto& seen = contents[i].box_m;
      const auto& before = record.content.box_m;
      if (are_one_place(before, seen) && !is_too_small_for(record, seen))
        pairs.push_back({likeness(before, seen), i, &record});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tuple(-a.likeness, a.record->id, a.content) < std::tuple(-b.likeness, b.record->id, b.content);
  });
  return pairs;
}

}  // namespace

bool are_one_place(const Eigen::AlignedBox3d& known, const Eigen::AlignedBox3d& seen) {
  if (known.isEmpty() || seen.isEmpty()) return false;
  const double volume_known = grown(known).volume();
  const double volume_seen = grown(seen).volume();
  const auto common = grown(known).intersection(grown(seen));
  if (common.isEmpty() || volume_seen > kMostTimesLarger * volume_known) return false;
  return common.volume() >= kLeastShared * std::min(volume_known, volume_seen);
}

std::vector<ProposalSighting> match_proposals(const std::vector<ProposalContent>& contents,
                                              const std::vector<ProposalRecord>& known) {
  std::vector<ProposalSighting> sightings;
  for (const auto& content : contents) sightings.push_back({std::nullopt, std::nullopt, content});
  std::vector<ProposalId> found;
  const auto pairs = possible_pairs(contents, known);
  for (const auto& pair : pairs) {
    const auto id = pair.record->id;
    if (sightings[pair.content].known || std::find(found.begin(), found.end(), id) != found.end()) continue;
    sightings[pair.content].known = id;
    auto& box = sightings[pair.content].content.box_m;
    const auto& before = pair.record->content.box_m;
    if (grown(before).volume() > grown(box).volume()) box = before;
    found.push_back(id);
  }
  for (const auto& pair : pairs) {
    auto& sighting = sightings[pair.content];
    if (sighting.known || sighting.piece_of_rejected || pair.record->state != ProposalState::rejected) continue;
    sighting.piece_of_rejected = pair.record->id;
  }
  return sightings;
}

}  // namespace meshloop
