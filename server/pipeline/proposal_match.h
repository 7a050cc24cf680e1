#pragma once
// Which proposals of a snapshot are those that the scene knows already. Pure.
#include <vector>

#include "server/store/proposal_record.h"

namespace meshloop {

/// Noise and another view change a box by so much on each side.
inline constexpr double kBoxMargin_m = 0.02;
/// Of the smaller box, how much the two must share.
inline constexpr double kLeastShared = 0.5;
/// By volume, how much more a view may show than the ones before; eight times is twice the size each way.
inline constexpr double kMostTimesLarger = 8;
/// By volume, how much smaller than what was rejected a view of it may be. More would have one rejected wall or room
/// reject all that ever stands in it.
inline constexpr double kMostTimesSmallerOfRejected = 8;

/// Both boxes grown by the margin: at least kLeastShared of the smaller one lies within the other, and `seen` has at
/// most kMostTimesLarger the volume of `known`. It may be smaller by any factor: of what was seen whole an edge shows
/// from elsewhere. An empty box is nowhere.
[[nodiscard]] bool are_one_place(const Eigen::AlignedBox3d& known, const Eigen::AlignedBox3d& seen);

/// One sighting for each content, in their order. A proposal is a known one when the kind and the place are the same
/// and the known one is open or rejected; what was accepted is over, and what is measured there now is something else.
/// So is what is more than kMostTimesSmallerOfRejected times smaller than a rejected one. The best pairs first, of
/// equal ones the lower id; each known one is found at most once. A further one at the place of a rejected one is a
/// piece of that. A known one keeps its box when it is the larger one, so that views from the edge do not lose the
/// place.
[[nodiscard]] std::vector<ProposalSighting> match_proposals(const std::vector<ProposalContent>& contents,
                                                            const std::vector<ProposalRecord>& known);

}  // namespace meshloop
