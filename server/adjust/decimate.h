#pragma once
#include "common/mesh/submesh.h"

namespace meshloop::adjust {

/// Borders that another surface is joined to must keep all their vertices.
enum class Border { decimated, kept };

/// Fewer triangles for the same surface, by quadric edge collapse (meshoptimizer; Garland and Heckbert 1997). Vertices
/// are left out, none is moved. The result lies within about `error_m` of the submesh, its brightness within about
/// `error_levels` of 255; straight borders stay where they are, whether they lose vertices or not. Both errors must be
/// above 0. The submesh must not be on a lattice yet: its rounding would count as form.
[[nodiscard]] Submesh decimate(const Submesh& submesh, double error_m, double error_levels, Border border);

}  // namespace meshloop::adjust
