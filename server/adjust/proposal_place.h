#pragma once
#include "server/adjust/proposal.h"

namespace meshloop::adjust {

/// Around what a proposal adds, takes away, or moves (where it was and where it is), in the world. The proposal must be
/// made of the model, and change something.
[[nodiscard]] Eigen::AlignedBox3d place_of(const Model& model, const Proposal& proposal);

/// Around all that moves, with the nodes along, after it was carried by T_world_old. The move must be of the model.
[[nodiscard]] Eigen::AlignedBox3d place_of(const Model& model, const Move& move, const Pose& T_world_old);

}  // namespace meshloop::adjust
