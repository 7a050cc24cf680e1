#pragma once
// Solids of revolution around z, for procedural objects.
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "common/mesh/submesh.h"

namespace meshloop {

/// (radius, z), from bottom to top on the outer side: then front faces look outward.
using Profile = std::vector<Eigen::Vector2f>;
/// Colour and scale of the radius at an angle around z and a position along the profile (0 for its first point).
using LatheColor = std::function<Rgb8(float angle, std::size_t position)>;
using LatheRadius = std::function<float(float angle, std::size_t position)>;

/// Part of a turn, in radians.
struct Sweep {
  float from = 0;
  float to = 0;
  int steps = 1;
};
[[nodiscard]] Sweep full_turn(int steps);

/// Adds the surface that the profile sweeps. Normals are smooth within one call and have a crease to other calls.
void add_lathe(Submesh& mesh, const Profile& profile, const Sweep& sweep, const LatheColor& color,
               const LatheRadius& radius_scale = nullptr);

/// The profile of a tube's surface around the circle of radius `ring` at height z.
[[nodiscard]] Profile tube_profile(float ring, float z, float thickness, int steps);

}  // namespace meshloop
