#pragma once
// Where rays meet a shape: the reference for shaders/implicit.frag, in double precision.
#include <array>
#include <optional>

#include "common/implicit/shape.h"

namespace meshloop {

/// The points origin + t * direction. The direction need not have length 1.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

struct ShapeHit {
  double t = 0;
  /// Whose surface it is.
  std::size_t primitive = 0;
};

/// True for points of the solid.
[[nodiscard]] bool contains(const Primitive& primitive, const Eigen::Vector3d& p_primitive);
[[nodiscard]] bool contains(const Shape& shape, const Eigen::Vector3d& p_node);

/// The outward normal of the primitive's surface nearest to a point, in the node's frame.
[[nodiscard]] Eigen::Vector3d normal_at(const Primitive& primitive, const Eigen::Vector3d& p_node);

/// The first point of the solid's surface with nearest < t < farthest, seen from outside or from inside. Roots of the
/// primitives' equations (linear and quadratic; for the torus a search to 1e-9 m) are candidates; one is on the solid's
/// surface when the formula's value depends on which side of that primitive the point is.
[[nodiscard]] std::optional<ShapeHit> cast_ray(const Shape& shape, const Ray& ray, double nearest, double farthest);

}  // namespace meshloop
