#pragma once
#include <vector>

#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// How much of what the removals take away is seen through. Pixels in which the removed surface is the one that is
/// expected (to 1 cm) count, those without a measurement too; of a cut triangle those within the lines. Seen through is
/// what the removal itself went by: the measurement lies behind by more than the region's threshold, at up to two
/// pixels beside a silhouette too. The snapshot must be valid, the removals be made of it.
[[nodiscard]] SeeThrough look_through(const Snapshot& snapshot, const std::vector<Removal>& removals);

}  // namespace meshloop::adjust
