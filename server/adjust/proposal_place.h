#pragma once
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// Around what a proposal adds, takes away, or moves (where it was and where it is), in the world. The proposal must be
/// made of the model, and change something.
[[nodiscard]] Eigen::AlignedBox3d place_of(const Model& model, const Proposal& proposal);

}  // namespace meshloop::adjust
