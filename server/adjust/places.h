#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace meshloop::adjust {

/// Numbers the places where vertices lie: those at the same place get the same number, since meshes with sharp edges
/// repeat their positions. The number is that of one of the vertices there.
[[nodiscard]] std::vector<std::uint32_t> places_of(const std::vector<Eigen::Vector3f>& positions);

}  // namespace meshloop::adjust
