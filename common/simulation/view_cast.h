#pragma once
// Finds the nearest solid along the rays of one view. The picture is cut into tiles; a tile knows the solids whose
// projected bounds touch it, nearest first, so that a ray meets a handful of solids instead of all.
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/camera.h"
#include "common/simulation/scene.h"

namespace meshloop::simulation {

struct Hit {
  /// Depth along the optical axis, metres.
  double depth_m = 0;
  /// Position in Scene::solids; -1 where no solid is hit.
  int solid = -1;
  /// As in solid_shape.h.
  int face = 0;
  /// In the solid's frame.
  Eigen::Vector3d p_solid = Eigen::Vector3d::Zero();
};

/// Immutable after construction: any number of threads may cast. The scene must outlive it.
class ViewCast {
 public:
  static constexpr int kTile = 16;

  ViewCast(const Scene& scene, const Camera& camera, const Pose& T_camera_world, bool modelled_only);

  [[nodiscard]] int tile_columns() const { return tile_columns_; }
  [[nodiscard]] int tile_rows() const { return tile_rows_; }
  /// Nearest surface behind the pixel (u, v), which may lie up to half a pixel outside the tile's pixels.
  [[nodiscard]] Hit cast(int tile_column, int tile_row, double u, double v) const;
  /// Where the ray of a pixel meets the plane of a flat face of a solid that `cast` found, in the solid's frame.
  [[nodiscard]] Eigen::Vector3d on_flat_face(int solid, int face, double u, double v) const;
  /// Direction of a pixel's ray in the camera frame, with z = 1.
  [[nodiscard]] Eigen::Vector3d ray(double u, double v) const { return camera_.back_project(u, v, 1); }

 private:
  struct Seen {
    Eigen::Matrix3d R_solid_camera;
    Eigen::Vector3d origin_solid;
    Eigen::Vector3d half;
    Solid::Shape shape;
    int index;
    double nearest_m;
    double u_min, u_max, v_min, v_max;
  };

  bool add_bounds(Seen& seen, const Pose& T_camera_solid) const;
  void fill_tiles();

  Camera camera_;
  std::vector<Seen> seen_;
  /// For each solid of the scene its position in seen_; meaningless where it is not seen.
  std::vector<std::size_t> position_;
  int tile_columns_;
  int tile_rows_;
  /// The solids of tile i are candidates_[first_[i]] to candidates_[first_[i + 1]].
  std::vector<std::uint32_t> first_;
  std::vector<std::uint16_t> candidates_;
};

}  // namespace meshloop::simulation
