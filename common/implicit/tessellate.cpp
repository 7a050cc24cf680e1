#include "common/implicit/tessellate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <limits>

#include "common/implicit/cast_ray.h"

namespace meshloop {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr auto kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// The surface's plane where it crosses edges of a cell, summed: the vertex that fits them best solves A x = b.
struct CellFit {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  Vector3d sum = Vector3d::Zero();
  int count = 0;

  void add(const Vector3d& point, const Vector3d& normal) {
    A += normal * normal.transpose();
    b += normal * normal.dot(point);
    sum += point;
    ++count;
  }

  /// Directions that the planes leave open stay at the mean of the crossings.
  [[nodiscard]] Vector3d vertex() const {
    const Vector3d mean = sum / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver{A};
    const Vector3d rest = solver.eigenvectors().transpose() * (b - A * mean);
    Vector3d move = Vector3d::Zero();
    for (Eigen::Index i = 0; i < 3; ++i) {
      constexpr double kOpen = 0.02;
      const double value = solver.eigenvalues()[i];
      if (value > kOpen * solver.eigenvalues()[2]) move += solver.eigenvectors().col(i) * (rest[i] / value);
    }
    return mean + move;
  }
};

class Contour {
 public:
  Contour(const Shape& shape, int cells) : shape_{shape} {
    const auto bounds = bounds_of(shape);
    step_ = bounds.sizes().maxCoeff() / cells;
    // Off the faces that lie in the bounds, by an uneven share of a cell.
    origin_ = bounds.min() - Vector3d::Constant(1.37 * step_);
    counts_ = ((bounds.sizes() / step_).array().ceil().cast<int>() + 4).matrix();
  }

  [[nodiscard]] double step() const { return step_; }

  Tessellation run() {
    classify();
    fits_.resize(inside_.size());
    std::vector<Crossing> crossings;
    for_each_edge([&](const Vector3i& at, int axis) { fit_edge(at, axis, crossings); });
    place_vertices();
    for (const auto& crossing : crossings) add_quad(crossing);
    return {std::move(mesh_), 0};
  }

 private:
  struct Crossing {
    Vector3i at;
    int axis;
    bool leaves;
  };

  [[nodiscard]] std::size_t index(const Vector3i& at) const {
    return (static_cast<std::size_t>(at.z()) * static_cast<std::size_t>(counts_.y()) +
            static_cast<std::size_t>(at.y())) *
               static_cast<std::size_t>(counts_.x()) +
           static_cast<std::size_t>(at.x());
  }
  [[nodiscard]] Vector3d point(const Vector3i& at) const { return origin_ + step_ * at.cast<double>(); }

  void classify() {
    inside_.resize(static_cast<std::size_t>(counts_.prod()));
    for (int z = 0; z < counts_.z(); ++z) {
      for (int y = 0; y < counts_.y(); ++y) {
        for (int x = 0; x < counts_.x(); ++x) inside_[index({x, y, z})] = contains(shape_, point({x, y, z}));
      }
    }
  }

  /// Edges with four cells around them.
  template <class Use>
  void for_each_edge(Use use) const {
    for (int z = 1; z + 1 < counts_.z(); ++z) {
      for (int y = 1; y + 1 < counts_.y(); ++y) {
        for (int x = 1; x + 1 < counts_.x(); ++x) {
          for (int axis = 0; axis < 3; ++axis) use(Vector3i{x, y, z}, axis);
        }
      }
    }
  }

  /// The cells around an edge, counter-clockwise seen against its direction.
  [[nodiscard]] std::array<Vector3i, 4> around(const Vector3i& at, int axis) const {
    const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
    return {at - u - v, at - v, at, at - u};
  }

  void fit_edge(const Vector3i& at, int axis, std::vector<Crossing>& crossings) {
    const Vector3i next = at + Vector3i::Unit(axis);
    const bool starts_inside = inside_[index(at)];
    if (starts_inside == inside_[index(next)]) return;
    const Vector3d from = point(at);
    const auto hit = cast_ray(shape_, {from, point(next) - from}, -1e-9, 1 + 1e-9);
    if (!hit) return;
    const Vector3d p = from + hit->t * (point(next) - from);
    const Vector3d normal = normal_at(shape_.primitives[hit->primitive], p);
    for (const auto& cell : around(at, axis)) fits_[index(cell)].add(p, normal);
    crossings.push_back({at, axis, starts_inside});
  }

  void place_vertices() {
    vertices_.assign(fits_.size(), kNoVertex);
    for (int z = 0; z + 1 < counts_.z(); ++z) {
      for (int y = 0; y + 1 < counts_.y(); ++y) {
        for (int x = 0; x + 1 < counts_.x(); ++x) {
          const auto cell = index({x, y, z});
          if (fits_[cell].count == 0) continue;
          const Vector3d low = point({x, y, z});
          const Vector3d p = fits_[cell].vertex().cwiseMax(low).cwiseMin(low + Vector3d::Constant(step_));
          vertices_[cell] = static_cast<std::uint32_t>(mesh_.positions.size());
          mesh_.positions.push_back(p.cast<float>());
        }
      }
    }
  }

  void add_quad(const Crossing& crossing) {
    std::array<std::uint32_t, 4> corner{};
    const auto cells = around(crossing.at, crossing.axis);
    for (std::size_t i = 0; i < 4; ++i) corner[i] = vertices_[index(cells[crossing.leaves ? i : 3 - i])];
    // The shorter diagonal follows a crease.
    const auto length = [&](std::size_t a, std::size_t b) {
      return (mesh_.positions[corner[a]] - mesh_.positions[corner[b]]).norm();
    };
    if (length(0, 2) <= length(1, 3)) {
      mesh_.triangles.push_back({corner[0], corner[1], corner[2]});
      mesh_.triangles.push_back({corner[0], corner[2], corner[3]});
    } else {
      mesh_.triangles.push_back({corner[0], corner[1], corner[3]});
      mesh_.triangles.push_back({corner[1], corner[2], corner[3]});
    }
  }

  const Shape& shape_;
  double step_ = 0;
  Vector3d origin_;
  Vector3i counts_;
  std::vector<bool> inside_;
  std::vector<CellFit> fits_;
  std::vector<std::uint32_t> vertices_;
  Submesh mesh_;
};

/// An upper bound of the distance from a point to the surface: along the primitives' normals there, and along the axes
/// and diagonals for points beyond an edge; `most` when nothing is met within it.
double distance_to(const Shape& shape, const Vector3d& p, double most) {
  double nearest = most;
  const auto look = [&](const Vector3d& direction) {
    if (const auto hit = cast_ray(shape, {p, direction}, -1e-9, nearest)) nearest = std::max(hit->t, 0.0);
  };
  for (const auto& primitive : shape.primitives) {
    const Vector3d normal = normal_at(primitive, p);
    look(normal);
    look(-normal);
  }
  constexpr double kNear_m = 1e-4;
  if (nearest < kNear_m) return nearest;
  for (int i = 0; i < 27; ++i) {
    if (i != 13) look(Vector3d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1).normalized());
  }
  return nearest;
}

/// Over corners, middles of triangles and of edges.
double error_of(const Shape& shape, const Submesh& mesh) {
  const double size = bounds_of(shape).sizes().maxCoeff();
  double worst = 0;
  const auto look = [&](const Vector3d& p) { worst = std::max(worst, distance_to(shape, p, size)); };
  for (const auto& p : mesh.positions) look(p.cast<double>());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d p = mesh.positions[a].cast<double>(), q = mesh.positions[b].cast<double>(),
                   r = mesh.positions[c].cast<double>();
    look((p + q + r) / 3);
    for (const Vector3d& middle : {Vector3d{(p + q) / 2}, Vector3d{(q + r) / 2}, Vector3d{(r + p) / 2}}) look(middle);
  }
  return worst;
}

/// Points of a primitive that are on the solid's surface: where rays through its box, from both sides, first meet it.
template <class Use>
void for_each_point_of(const Shape& shape, std::size_t primitive, Use use) {
  constexpr int kRays = 12;
  const auto box = bounds_of(shape).intersection(bounds_of(shape.primitives[primitive]));
  if (box.isEmpty()) return;
  const double margin = 0.01 * box.sizes().maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < kRays * kRays * 2; ++i) {
      Vector3d from = box.min();
      from[u] += (i % kRays + 0.5) / kRays * box.sizes()[u];
      from[v] += (i / kRays % kRays + 0.5) / kRays * box.sizes()[v];
      const double side = i < kRays * kRays ? 1 : -1;
      from[axis] = side > 0 ? box.min()[axis] - margin : box.max()[axis] + margin;
      const Vector3d direction = side * Vector3d::Unit(axis);
      const auto hit = cast_ray(shape, {from, direction}, 0, box.sizes()[axis] + 2 * margin);
      if (hit && hit->primitive == primitive) use(Vector3d{from + hit->t * direction});
    }
  }
}

/// How far a part of the surface lies from all corners, beyond the two cells that it may: what fell between the points
/// of the grid.
double missing_by(const Shape& shape, const Submesh& mesh, double step) {
  double worst = 0;
  for (std::size_t i = 0; i < shape.primitives.size(); ++i) {
    for_each_point_of(shape, i, [&](const Vector3d& p) {
      double nearest = std::numeric_limits<double>::infinity();
      const double enough = worst + 2 * step;
      for (const auto& q : mesh.positions) {
        nearest = std::min(nearest, (q.cast<double>() - p).norm());
        if (nearest <= enough) return;
      }
      worst = nearest - 2 * step;
    });
  }
  return worst;
}

}  // namespace

Result<Tessellation> tessellate(const Shape& shape, int cells) {
  if (auto ok = validate(shape); !ok) return fail(ok.error());
  Contour contour{shape, cells};
  auto result = contour.run();
  if (result.submesh.triangles.empty()) return fail("a shape is empty, or thinner than the grid of its triangles");
  if (shape.color) result.submesh.colors.assign(result.submesh.positions.size(), *shape.color);
  result.error_m = std::max(error_of(shape, result.submesh), missing_by(shape, result.submesh, contour.step()));
  return result;
}

}  // namespace meshloop
