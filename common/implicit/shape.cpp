#include "common/implicit/shape.h"

#include <fmt/format.h>

#include <limits>

namespace meshloop {
namespace {

using Box = Eigen::AlignedBox3d;
using Kind = Primitive::Kind;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kLargest_m = 1000;

bool has_sizes(const Primitive& primitive) {
  const auto good = [&](Eigen::Index i) { return primitive.size[i] > 0 && primitive.size[i] <= kLargest_m; };
  switch (primitive.kind) {
    case Kind::sphere:
      return good(0);
    case Kind::box:
      return good(0) && good(1) && good(2);
    case Kind::plane:
      return true;
    case Kind::cylinder:
    case Kind::cone:
      return good(0) && good(1);
    case Kind::torus:
      return good(0) && good(1) && primitive.size.x() > primitive.size.y();
  }
  return false;
}

Box own_bounds(const Primitive& primitive) {
  const Eigen::Vector3d& size = primitive.size;
  const auto about = [](double x, double y, double z) {
    return Box{Eigen::Vector3d{-x, -y, -z}, Eigen::Vector3d{x, y, z}};
  };
  switch (primitive.kind) {
    case Kind::sphere:
      return about(size.x(), size.x(), size.x());
    case Kind::box:
      return about(size.x() / 2, size.y() / 2, size.z() / 2);
    case Kind::cylinder:
      return about(size.x(), size.x(), size.y() / 2);
    case Kind::cone:
      return {Eigen::Vector3d{-size.x(), -size.x(), 0}, Eigen::Vector3d{size.x(), size.x(), size.y()}};
    case Kind::torus:
      return about(size.x() + size.y(), size.x() + size.y(), size.y());
    case Kind::plane:
      break;
  }
  return about(kInfinite, kInfinite, kInfinite);
}

}  // namespace

Box bounds_of(const Primitive& primitive) {
  const Pose T_node_primitive = primitive.T_primitive_node.inverse();
  if (primitive.kind != Kind::plane) return own_bounds(primitive).transformed(T_node_primitive);
  Box bounds = own_bounds(primitive);
  // A plane across one of the axes ends the solid there.
  const Eigen::Vector3d normal = T_node_primitive.linear().col(2);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double at = T_node_primitive.translation()[axis];
    if (normal[axis] > 1 - 1e-12) bounds.max()[axis] = at;
    if (normal[axis] < -1 + 1e-12) bounds.min()[axis] = at;
  }
  return bounds;
}

Eigen::AlignedBox3d bounds_of(const Shape& shape) {
  std::vector<Box> stack;
  for (const auto& step : shape.steps) {
    if (step.value >= 0) {
      stack.push_back(bounds_of(shape.primitives[static_cast<std::size_t>(step.value)]));
      continue;
    }
    const Box second = stack.back();
    stack.pop_back();
    if (step.value == ShapeStep::kUnion) stack.back().extend(second);
    if (step.value == ShapeStep::kIntersection) stack.back() = stack.back().intersection(second);
  }
  return stack.empty() ? Box{} : stack.back();
}

Status validate(const Shape& shape) {
  if (shape.primitives.size() > kMaxPrimitives) {
    return fail(
        fmt::format("a shape has {} primitives; at most {} are drawn", shape.primitives.size(), kMaxPrimitives));
  }
  for (const auto& primitive : shape.primitives) {
    if (!has_sizes(primitive)) return fail("a primitive's sizes are not between 0 and 1000 m, or a torus has no hole");
    if (!is_rigid(primitive.T_primitive_node)) return fail("a primitive's transform is not rigid");
  }
  if (shape.steps.size() > kMaxSteps) {
    return fail(fmt::format("a shape's formula has {} steps; at most {} are drawn", shape.steps.size(), kMaxSteps));
  }
  int depth = 0;
  for (const auto& step : shape.steps) {
    const bool known = step.value >= ShapeStep::kDifference && step.value < static_cast<int>(shape.primitives.size());
    depth += step.value >= 0 ? 1 : -1;
    if (!known || depth < 1 || depth > kMaxStack)
      return fail("a shape's formula is not complete, or is nested too deeply");
  }
  if (depth != 1) return fail("a shape's formula is not complete");
  const auto bounds = bounds_of(shape);
  if (bounds.isEmpty()) return fail("a shape is empty: its parts do not meet");
  if (!bounds.min().allFinite() || !bounds.max().allFinite()) {
    return fail("a shape has no end; intersect its planes with a box");
  }
  constexpr double kThinnest_m = 1e-6;
  constexpr double kFarthest_m = 1e4;
  if (bounds.sizes().minCoeff() < kThinnest_m) return fail("a shape has no volume: its parts only touch");
  if (bounds.min().cwiseAbs().cwiseMax(bounds.max().cwiseAbs()).maxCoeff() > kFarthest_m) {
    return fail("a shape lies more than 10 km from its origin");
  }
  return {};
}

}  // namespace meshloop
