#pragma once
// The demo's light: one lamp far away with exact hard shadows, a weak lamp without shadows from the other side, and the
// sky's ambient light.
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/simulation/scene.h"

namespace meshloop::simulation {

/// Immutable after construction: any number of threads may ask. The scene must outlive it.
class Light {
 public:
  explicit Light(const Scene& scene);

  [[nodiscard]] bool is_turned_to_lamp(const Eigen::Vector3d& normal_world) const {
    return normal_world.dot(to_lamp_) > 0;
  }
  /// Whether the lamp reaches a point on a face of solid `index` that is turned to the lamp.
  [[nodiscard]] bool reaches(const Eigen::Vector3d& p_world, int index) const;
  /// By how much a surface's colour is multiplied.
  [[nodiscard]] double brightness(const Eigen::Vector3d& normal_world, bool reached) const;

 private:
  struct Blocker {
    Eigen::Matrix3d R_solid_world;
    Eigen::Vector3d origin_world;
    Eigen::Vector3d half;
    Eigen::Vector3d direction_solid;
    Solid::Shape shape;
    /// Range of cells in the plane across the light.
    int column_min, column_max, row_min, row_max;
  };

  /// Directions from the scene to the lamps, and two axes of the plane across the lamp's light.
  Eigen::Vector3d to_lamp_ = Eigen::Vector3d(-0.50, -0.26, 0.83).normalized();
  Eigen::Vector3d to_fill_ = Eigen::Vector3d(0.55, 0.55, 0.45).normalized();
  Eigen::Vector3d across_ = to_lamp_.cross(Eigen::Vector3d::UnitY()).normalized();
  Eigen::Vector3d along_ = to_lamp_.cross(across_);

  [[nodiscard]] int column_of(const Eigen::Vector3d& p_world) const;
  [[nodiscard]] int row_of(const Eigen::Vector3d& p_world) const;
  void fill_cells();

  std::vector<Blocker> blockers_;
  /// The solids that may darken cell i are in_cell_[first_[i]] to in_cell_[first_[i + 1]].
  std::vector<std::uint32_t> first_;
  std::vector<std::uint16_t> in_cell_;
};

}  // namespace meshloop::simulation
