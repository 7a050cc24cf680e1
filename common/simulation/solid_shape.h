#pragma once
// Where a line meets a solid, in the solid's own frame.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "common/simulation/scene.h"

namespace meshloop::simulation {

/// Faces of a box in the order -x, +x, -y, +y, -z, +z; a cylinder has the last two and its mantle.
inline constexpr int kMantle = 6;

/// The part of a line inside a solid, and the face through which it enters. Empty when t_in > t_out.
struct Crossing {
  double t_in = -std::numeric_limits<double>::infinity();
  double t_out = std::numeric_limits<double>::infinity();
  int face = 0;
  [[nodiscard]] bool hit() const { return t_in <= t_out; }
};

inline void cut_slab(Crossing& crossing, double origin, double direction, double half, int axis) {
  // A direction of 0 gives infinities of the right signs, or NaN on the very face, which the comparisons pass over.
  const double inverse = 1 / direction;
  const bool backwards = std::signbit(direction);
  const double towards = backwards ? half : -half;
  const double t_first = (towards - origin) * inverse;
  const double t_second = (-towards - origin) * inverse;
  if (t_first > crossing.t_in) {
    crossing.t_in = t_first;
    crossing.face = 2 * axis + (backwards ? 1 : 0);
  }
  if (t_second < crossing.t_out) crossing.t_out = t_second;
}

inline void cut_mantle(Crossing& crossing, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                       double radius) {
  const double a = direction.x() * direction.x() + direction.y() * direction.y();
  const double b = origin.x() * direction.x() + origin.y() * direction.y();
  const double c = origin.x() * origin.x() + origin.y() * origin.y() - radius * radius;
  const double discriminant = b * b - a * c;
  if (discriminant < 0 || (a == 0 && c > 0)) {
    crossing.t_out = -std::numeric_limits<double>::infinity();
    return;
  }
  if (a == 0) return;
  const double root = std::sqrt(discriminant);
  const double t_first = (-b - root) / a;
  if (t_first > crossing.t_in) {
    crossing.t_in = t_first;
    crossing.face = kMantle;
  }
  crossing.t_out = std::min(crossing.t_out, (-b + root) / a);
}

/// `half`: half of Solid::size.
[[nodiscard]] inline Crossing cross_solid(Solid::Shape shape, const Eigen::Vector3d& half,
                                          const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  Crossing crossing;
  cut_slab(crossing, origin.z(), direction.z(), half.z(), 2);
  if (!crossing.hit()) return crossing;
  if (shape == Solid::Shape::cylinder) {
    cut_mantle(crossing, origin, direction, half.x());
    return crossing;
  }
  cut_slab(crossing, origin.x(), direction.x(), half.x(), 0);
  if (!crossing.hit()) return crossing;
  cut_slab(crossing, origin.y(), direction.y(), half.y(), 1);
  return crossing;
}

/// Outward normal of a face at a point of it.
[[nodiscard]] inline Eigen::Vector3d normal_of_face(int face, const Eigen::Vector3d& p_solid) {
  if (face == kMantle) return Eigen::Vector3d(p_solid.x(), p_solid.y(), 0).normalized();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[face / 2] = face % 2 == 0 ? -1 : 1;
  return normal;
}

}  // namespace meshloop::simulation
