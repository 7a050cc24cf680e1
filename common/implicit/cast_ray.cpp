#include "common/implicit/cast_ray.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace meshloop {
namespace {

using Kind = Primitive::Kind;
using Eigen::Vector3d;

/// Where a ray crosses a primitive's surface, in no order.
struct Roots {
  std::array<double, 8> t{};
  int count = 0;
  void add(double value) {
    if (std::isfinite(value) && count < static_cast<int>(t.size())) t[static_cast<std::size_t>(count++)] = value;
  }
};

/// Roots of a t² + 2 b t + c.
void add_quadratic(double a, double b, double c, Roots& roots, auto keep) {
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0) || a == 0) {
    if (a == 0 && b != 0 && keep(-c / (2 * b))) roots.add(-c / (2 * b));
    return;
  }
  const double root = std::sqrt(discriminant);
  for (const double t : {(-b - root) / a, (-b + root) / a}) {
    if (keep(t)) roots.add(t);
  }
}

void add_disc(const Ray& ray, double z, double radius, Roots& roots) {
  const double t = (z - ray.origin.z()) / ray.direction.z();
  if (!std::isfinite(t)) return;
  const Vector3d p = ray.origin + t * ray.direction;
  if (p.head<2>().squaredNorm() <= radius * radius) roots.add(t);
}

void add_box(const Ray& ray, const Vector3d& half, Roots& roots) {
  double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double a = (-half[axis] - ray.origin[axis]) / ray.direction[axis];
    const double b = (half[axis] - ray.origin[axis]) / ray.direction[axis];
    if (ray.direction[axis] == 0) {
      if (std::abs(ray.origin[axis]) > half[axis]) return;
      continue;
    }
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave) return;
  roots.add(enter);
  roots.add(leave);
}

double torus_distance(const Vector3d& p, const Vector3d& size) {
  return std::hypot(std::hypot(p.x(), p.y()) - size.x(), p.z()) - size.y();
}

/// Steps as long as the distance to the surface allows; each change of sign is halved down to 1e-9 m.
void add_torus(const Ray& ray, const Vector3d& size, double nearest, double farthest, Roots& roots) {
  constexpr double kSmallestStep_m = 1e-5, kAccuracy_m = 1e-9;
  Roots range;
  const double outer = size.x() + size.y(), speed = ray.direction.norm();
  add_quadratic(ray.direction.squaredNorm(), ray.origin.dot(ray.direction), ray.origin.squaredNorm() - outer * outer,
                range, [](double) { return true; });
  if (range.count < 2) return;
  const auto distance = [&](double t) { return torus_distance(ray.origin + t * ray.direction, size); };
  double t = std::max(range.t[0], nearest), here = distance(t);
  while (t < std::min(range.t[1], farthest)) {
    const double next = t + std::max(std::abs(here), kSmallestStep_m) / speed;
    const double there = distance(next);
    if ((here > 0) != (there > 0)) {
      double low = t, high = next;
      while ((high - low) * speed > kAccuracy_m) {
        const double middle = (low + high) / 2;
        ((distance(middle) > 0) == (here > 0) ? low : high) = middle;
      }
      roots.add((low + high) / 2);
    }
    t = next;
    here = there;
  }
}

/// Those between nearest and farthest; perhaps others.
Roots roots_of(const Primitive& primitive, const Ray& ray, double nearest, double farthest) {
  Roots roots;
  const Vector3d &o = ray.origin, &d = ray.direction, &size = primitive.size;
  const auto height = [&](double t) { return o.z() + t * d.z(); };
  switch (primitive.kind) {
    case Kind::sphere:
      add_quadratic(d.squaredNorm(), o.dot(d), o.squaredNorm() - size.x() * size.x(), roots,
                    [](double) { return true; });
      break;
    case Kind::box:
      add_box(ray, size / 2, roots);
      break;
    case Kind::plane:
      roots.add(-o.z() / d.z());
      break;
    case Kind::cylinder:
      add_quadratic(d.head<2>().squaredNorm(), o.head<2>().dot(d.head<2>()),
                    o.head<2>().squaredNorm() - size.x() * size.x(), roots,
                    [&](double t) { return std::abs(height(t)) <= size.y() / 2; });
      add_disc(ray, size.y() / 2, size.x(), roots);
      add_disc(ray, -size.y() / 2, size.x(), roots);
      break;
    case Kind::cone: {
      // x² + y² = (k (z - h))², of which the part below the point counts.
      const double k = size.x() / size.y(), above = o.z() - size.y();
      add_quadratic(d.head<2>().squaredNorm() - k * k * d.z() * d.z(),
                    o.head<2>().dot(d.head<2>()) - k * k * above * d.z(),
                    o.head<2>().squaredNorm() - k * k * above * above, roots,
                    [&](double t) { return height(t) >= 0 && height(t) <= size.y(); });
      add_disc(ray, 0, size.x(), roots);
      break;
    }
    case Kind::torus:
      add_torus(ray, size, nearest, farthest, roots);
      break;
  }
  return roots;
}

/// The formula's value, as bits of a stack. `forced` (when it is an index) has the value that is given.
bool evaluate(const Shape& shape, const Vector3d& p_node, std::optional<std::size_t> forced, bool value) {
  std::uint64_t stack = 0;
  for (const auto& step : shape.steps) {
    if (step.value >= 0) {
      const auto index = static_cast<std::size_t>(step.value);
      const Primitive& primitive = shape.primitives[index];
      const bool in = forced == index ? value : contains(primitive, primitive.T_primitive_node * p_node);
      stack = stack << 1 | (in ? 1u : 0u);
      continue;
    }
    const bool second = stack & 1, first = stack >> 1 & 1;
    const bool result = step.value == ShapeStep::kUnion          ? first || second
                        : step.value == ShapeStep::kIntersection ? first && second
                                                                 : first && !second;
    stack = stack >> 2 << 1 | (result ? 1u : 0u);
  }
  return stack & 1;
}

}  // namespace

bool contains(const Primitive& primitive, const Vector3d& p) {
  const Vector3d& size = primitive.size;
  switch (primitive.kind) {
    case Kind::sphere:
      return p.squaredNorm() <= size.x() * size.x();
    case Kind::box:
      return (p.cwiseAbs().array() <= size.array() / 2).all();
    case Kind::plane:
      return p.z() <= 0;
    case Kind::cylinder:
      return p.head<2>().norm() <= size.x() && std::abs(p.z()) <= size.y() / 2;
    case Kind::cone:
      return p.z() >= 0 && p.head<2>().norm() <= size.x() * (1 - p.z() / size.y());
    case Kind::torus:
      return torus_distance(p, size) <= 0;
  }
  return false;
}

bool contains(const Shape& shape, const Vector3d& p_node) {
  return evaluate(shape, p_node, std::nullopt, false);
}

std::optional<ShapeHit> cast_ray(const Shape& shape, const Ray& ray, double nearest, double farthest) {
  std::optional<ShapeHit> first;
  for (std::size_t i = 0; i < shape.primitives.size(); ++i) {
    const Pose& T = shape.primitives[i].T_primitive_node;
    const Roots roots = roots_of(shape.primitives[i], {T * ray.origin, T.linear() * ray.direction}, nearest,
                                 first ? first->t : farthest);
    for (int r = 0; r < roots.count; ++r) {
      const double t = roots.t[static_cast<std::size_t>(r)];
      if (!(t > nearest && t < farthest) || (first && t >= first->t)) continue;
      const Vector3d p = ray.origin + t * ray.direction;
      if (evaluate(shape, p, i, true) != evaluate(shape, p, i, false)) first = ShapeHit{t, i};
    }
  }
  return first;
}

Vector3d normal_at(const Primitive& primitive, const Vector3d& p_node) {
  const Vector3d p = primitive.T_primitive_node * p_node;
  const Vector3d& size = primitive.size;
  const Vector3d radial = Vector3d{p.x(), p.y(), 0}.normalized();
  const double r = p.head<2>().norm();
  const auto up = [&p] { return Vector3d{0, 0, p.z() < 0 ? -1.0 : 1.0}; };
  const auto normal = [&]() -> Vector3d {
    switch (primitive.kind) {
      case Kind::sphere:
        return p.normalized();
      case Kind::box: {
        Eigen::Index axis = 0;
        (p.cwiseAbs() - size / 2).maxCoeff(&axis);
        return Vector3d::Unit(axis) * (p[axis] < 0 ? -1 : 1);
      }
      case Kind::cylinder:
        return std::abs(r - size.x()) < std::abs(std::abs(p.z()) - size.y() / 2) ? radial : up();
      case Kind::cone: {
        const Vector3d side = (size.y() * radial + Vector3d{0, 0, size.x()}).normalized();
        return std::abs(side.dot(p) - side.z() * size.y()) < std::abs(p.z()) ? side : Vector3d{0, 0, -1};
      }
      case Kind::torus:
        return (p - size.x() * radial).normalized();
      case Kind::plane:
        break;
    }
    return Vector3d::UnitZ();
  };
  return primitive.T_primitive_node.linear().transpose() * normal();
}

}  // namespace meshloop
