#pragma once
#include <functional>

#include "common/simulation/scene.h"

namespace meshloop::simulation {

/// A room seen from its middle, walls 7 m away: soft walls with pictures, shelves and windows. A function of the
/// direction alone, since it is too far away for parallax to matter.
[[nodiscard]] std::function<Rgb8(const Eigen::Vector3d& direction)> living_room(std::uint64_t seed);

}  // namespace meshloop::simulation
