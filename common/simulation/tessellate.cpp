// Solids as triangle meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "common/simulation/scene.h"

namespace meshloop::simulation {
namespace {

// How far a cylinder's chords may lie below its mantle.
constexpr double kSagitta_m = 0.0002;
constexpr int kFewestSegments = 24;

int pieces(double length_m, double edge_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / edge_m - 1e-9)));
}

/// Adds one solid's surface to a mesh in world coordinates.
class SolidMesher {
 public:
  SolidMesher(const Solid& solid, double edge_m, Submesh& mesh)
      : solid_{solid}, edge_m_{edge_m / std::numbers::sqrt2 / std::max(1.0, solid.mesh_detail)}, mesh_{mesh} {}

  void add_box() {
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) add_box_face(axis, sign);
    }
  }

  void add_cylinder() {
    const double radius = solid_.size.x() / 2;
    const double half = solid_.size.z() / 2;
    const int segments = segments_of(radius);
    add_grid(segments, pieces(solid_.size.z(), edge_m_), [&](double s, double t) {
      const Eigen::Vector3d normal = around(s);
      return Vertex{radius * normal + Eigen::Vector3d(0, 0, (2 * t - 1) * half), normal};
    });
    for (const double sign : {-1.0, 1.0}) {
      add_grid(segments, pieces(radius, edge_m_), [&](double s, double t) {
        const Eigen::Vector3d rim = radius * (1 - t) * around(sign * s);
        return Vertex{rim + Eigen::Vector3d(0, 0, sign * half), Eigen::Vector3d(0, 0, sign)};
      });
    }
  }

 private:
  struct Vertex {
    Eigen::Vector3d p_solid;
    Eigen::Vector3d normal_solid;
  };

  static Eigen::Vector3d around(double turns) {
    const double angle = 2 * std::numbers::pi * turns;
    return {std::cos(angle), std::sin(angle), 0};
  }

  [[nodiscard]] int segments_of(double radius) const {
    const int for_sagitta =
        static_cast<int>(std::ceil(std::numbers::pi / std::acos(1 - std::min(1.0, kSagitta_m / radius))));
    return std::max({kFewestSegments, for_sagitta, pieces(2 * std::numbers::pi * radius, edge_m_)});
  }

  void add_box_face(int axis, double sign) {
    const int right = (axis + 1) % 3;
    const int up = (axis + 2) % 3;
    add_grid(pieces(solid_.size[right], edge_m_), pieces(solid_.size[up], edge_m_), [&](double s, double t) {
      Vertex vertex{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
      vertex.normal_solid[axis] = sign;
      vertex.p_solid[axis] = sign * solid_.size[axis] / 2;
      vertex.p_solid[right] = sign * (s - 0.5) * solid_.size[right];
      vertex.p_solid[up] = (t - 0.5) * solid_.size[up];
      return vertex;
    });
  }

  // A grid of columns x rows quads, counter-clockwise seen from where s grows to the right and t upwards. Triangles
  // without area, at the centre of a cylinder's end, are left out.
  void add_grid(int columns, int rows, const std::function<Vertex(double, double)>& vertex_at) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto stride = static_cast<std::uint32_t>(columns + 1);
    for (int row = 0; row <= rows; ++row) {
      for (int column = 0; column <= columns; ++column) {
        add_vertex(vertex_at(static_cast<double>(column) / columns, static_cast<double>(row) / rows));
      }
    }
    for (std::uint32_t row = 0; row < static_cast<std::uint32_t>(rows); ++row) {
      for (std::uint32_t column = 0; column + 1 < stride; ++column) {
        const std::uint32_t a = first + row * stride + column;
        add_triangle({a, a + 1, a + 1 + stride});
        add_triangle({a, a + 1 + stride, a + stride});
      }
    }
  }

  void add_vertex(const Vertex& vertex) {
    mesh_.positions.push_back((solid_.T_world_solid * vertex.p_solid).cast<float>());
    const Texture& texture = solid_.mesh_texture ? solid_.mesh_texture : solid_.texture;
    mesh_.colors.push_back(texture(vertex.p_solid, vertex.normal_solid));
  }

  void add_triangle(const Triangle& triangle) {
    const auto& p = mesh_.positions;
    const auto same = [&](int i, int j) {
      return (p[triangle[static_cast<std::size_t>(i)]] - p[triangle[static_cast<std::size_t>(j)]]).norm() < 1e-6f;
    };
    if (!same(0, 1) && !same(1, 2) && !same(2, 0)) mesh_.triangles.push_back(triangle);
  }

  const Solid& solid_;
  /// Sides of the quads, so that their diagonals keep to the edge length asked for.
  double edge_m_;
  Submesh& mesh_;
};

SolidMesh& mesh_of(std::vector<SolidMesh>& meshes, const std::string& name) {
  const auto it = std::find_if(meshes.begin(), meshes.end(), [&](const SolidMesh& mesh) { return mesh.name == name; });
  return it != meshes.end() ? *it : meshes.emplace_back(SolidMesh{name, {}});
}

}  // namespace

std::vector<SolidMesh> tessellate(const Scene& scene, bool modelled_only, double edge_m) {
  std::vector<SolidMesh> meshes;
  for (const Solid& solid : scene.solids) {
    if (modelled_only && !solid.modelled) continue;
    SolidMesher mesher(solid, edge_m, mesh_of(meshes, solid.object).submesh);
    if (solid.shape == Solid::Shape::box) {
      mesher.add_box();
    } else {
      mesher.add_cylinder();
    }
  }
  return meshes;
}

}  // namespace meshloop::simulation
