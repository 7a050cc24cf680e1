#pragma once
// Solids described by formulas: primitives, combined by union, intersection and difference.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/pose.h"
#include "common/image/image.h"

namespace meshloop {

/// A solid in a frame of its own. Sizes in metres, all positive.
struct Primitive {
  enum class Kind : std::uint8_t {
    /// Radius size.x, about the origin.
    sphere,
    /// Sides size.x, size.y, size.z, about the origin.
    box,
    /// All points with z <= 0; no size.
    plane,
    /// Radius size.x, height size.y along z, about the origin.
    cylinder,
    /// Radius size.x at z = 0, a point at z = size.y.
    cone,
    /// A tube of radius size.y around a circle of radius size.x > size.y in the plane z = 0.
    torus,
  };
  Kind kind = Kind::sphere;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  Pose T_primitive_node = Pose::Identity();
};

/// One step of a shape's formula in postfix order: a primitive is pushed, an operation takes two values and pushes one.
struct ShapeStep {
  static constexpr int kUnion = -1;
  static constexpr int kIntersection = -2;
  /// The first without the second.
  static constexpr int kDifference = -3;
  /// Index of a primitive, or one of the operations.
  int value = 0;
};

inline constexpr std::size_t kMaxPrimitives = 64;
/// A primitive may be named more than once.
inline constexpr std::size_t kMaxSteps = 2 * kMaxPrimitives;
/// Values that a formula may have on its stack.
inline constexpr int kMaxStack = 32;

/// A solid in its node's frame. Where faces of two of its primitives coincide, which of them counts is left to
/// rounding: let a body that is taken away reach beyond the surface.
struct Shape {
  std::vector<Primitive> primitives;
  std::vector<ShapeStep> steps;
  std::optional<Rgb8> color;
};

/// Refuses a formula that is too long or does not end in one value, sizes that are not positive, and a solid that has
/// no end, no volume (its bounds tell) or a part farther than 10 km from its origin.
[[nodiscard]] Status validate(const Shape& shape);

/// A box around a primitive in the node's frame: not the smallest. Without an end in some direction for planes.
[[nodiscard]] Eigen::AlignedBox3d bounds_of(const Primitive& primitive);
/// A box around the solid in the node's frame: not the smallest. Without an end in some direction for planes.
[[nodiscard]] Eigen::AlignedBox3d bounds_of(const Shape& shape);

}  // namespace meshloop
