#pragma once
#include <cstdint>
#include <span>

#include "common/mesh/submesh.h"

namespace meshloop {

/// Positions of a scene lie on one lattice of points `spacing_m` apart, so that nodes which meet in a point still meet
/// after they were compressed, and what the station stores is bit for bit what devices decode. The spacing is a power
/// of two, hence exact in floating point: 2^-12 m = 0.244 mm, a rounding error of at most 0.122 mm per axis, a tenth
/// of a Kinect's noise at its nearest range.
inline constexpr float kLatticeSpacing_m = 1.0f / 4096;

/// Every second, fourth or eighth point of each axis is a lattice too. A surface that was measured with more noise than
/// the finest one has can lie on a coarser one, and is then sent with fewer bits.
inline constexpr int kMaxCoarsening = 8;

/// Colours that hold a camera's noise are sent in steps too; 255 is none, and a white pixel becomes 248.
inline constexpr int kCoarseColorStep = 8;

/// The nearest point of the lattice.
[[nodiscard]] Eigen::Vector3f on_lattice(const Eigen::Vector3f& p);

/// To the bit: -0 is not on the lattice.
[[nodiscard]] bool is_on_lattice(const Submesh& submesh);
/// On the lattice coarsened by 1, 2, 4 or 8.
[[nodiscard]] bool is_on_lattice(const Eigen::Vector3f& p, int coarsening);

/// The largest of 1, 2, 4 and 8 so that every position lies on the lattice coarsened by it. The submesh must be on the
/// lattice.
[[nodiscard]] int coarsening_of(const Submesh& submesh);

/// Moves every position to the nearest point of the lattice coarsened by 1, 2, 4 or 8, and the vertices `finest` to the
/// nearest one of the finest lattice. Triangles that thereby lose their area, and vertices that nothing uses any more,
/// are dropped; vertices stay separate. May leave no triangles (the result is then not valid).
[[nodiscard]] Submesh snap_to_lattice(Submesh submesh, int coarsening = 1, std::span<const std::uint32_t> finest = {});

}  // namespace meshloop
