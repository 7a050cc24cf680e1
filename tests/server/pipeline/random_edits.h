#pragma once
#include <random>
#include <vector>

#include "common/mesh/model.h"

namespace meshloop::test {

/// One change as an operator may accept it: nodes that come, go, move, or lose a part of their triangles, one or
/// several together. Edits fit the model; `free_id` is the first id that no node has used.
[[nodiscard]] std::vector<Edit> random_edits(std::mt19937& random, const Model& model, NodeId free_id);

/// A place for a node. Zeros of both signs are among its numbers.
[[nodiscard]] Pose random_pose(std::mt19937& random);

}  // namespace meshloop::test
