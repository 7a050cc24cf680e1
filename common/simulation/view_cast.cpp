#include "common/simulation/view_cast.h"

#include <algorithm>
#include <limits>

#include "common/simulation/solid_shape.h"

namespace meshloop::simulation {
namespace {

// Nearer than this a corner's projection is of no use; the solid then counts as everywhere in the picture.
constexpr double kNear_m = 0.02;
// Rays of supersampling leave their tile by up to half a pixel.
constexpr double kMargin_px = 1;

}  // namespace

ViewCast::ViewCast(const Scene& scene, const Camera& camera, const Pose& T_camera_world, bool modelled_only)
    : camera_{camera},
      tile_columns_{(camera.width + kTile - 1) / kTile},
      tile_rows_{(camera.height + kTile - 1) / kTile} {
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    const Solid& solid = scene.solids[i];
    if (modelled_only && !solid.modelled) continue;
    const Pose T_camera_solid = T_camera_world * solid.T_world_solid;
    Seen seen{};
    seen.R_solid_camera = T_camera_solid.linear().transpose();
    seen.origin_solid = -seen.R_solid_camera * T_camera_solid.translation();
    seen.half = solid.size / 2;
    seen.shape = solid.shape;
    seen.index = static_cast<int>(i);
    if (add_bounds(seen, T_camera_solid)) seen_.push_back(seen);
  }
  std::stable_sort(seen_.begin(), seen_.end(), [](const Seen& a, const Seen& b) { return a.nearest_m < b.nearest_m; });
  position_.resize(scene.solids.size());
  for (std::size_t i = 0; i < seen_.size(); ++i) position_[static_cast<std::size_t>(seen_[i].index)] = i;
  fill_tiles();
}

// False when the solid lies behind the camera or outside the picture.
bool ViewCast::add_bounds(Seen& seen, const Pose& T_camera_solid) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double farthest = -kInfinity;
  seen.nearest_m = kInfinity;
  seen.u_min = seen.v_min = kInfinity;
  seen.u_max = seen.v_max = -kInfinity;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    const Eigen::Vector3d p = T_camera_solid * seen.half.cwiseProduct(sign);
    seen.nearest_m = std::min(seen.nearest_m, p.z());
    farthest = std::max(farthest, p.z());
    if (p.z() < kNear_m) continue;
    const Eigen::Vector2d pixel = camera_.project(p);
    seen.u_min = std::min(seen.u_min, pixel.x() - kMargin_px);
    seen.u_max = std::max(seen.u_max, pixel.x() + kMargin_px);
    seen.v_min = std::min(seen.v_min, pixel.y() - kMargin_px);
    seen.v_max = std::max(seen.v_max, pixel.y() + kMargin_px);
  }
  if (farthest < kNear_m) return false;
  if (seen.nearest_m < kNear_m) {
    seen.u_min = seen.v_min = -kInfinity;
    seen.u_max = seen.v_max = kInfinity;
  }
  return seen.u_max >= 0 && seen.v_max >= 0 && seen.u_min <= camera_.width && seen.v_min <= camera_.height;
}

void ViewCast::fill_tiles() {
  for (int row = 0; row < tile_rows_; ++row) {
    for (int column = 0; column < tile_columns_; ++column) {
      first_.push_back(static_cast<std::uint32_t>(candidates_.size()));
      const double u = column * kTile;
      const double v = row * kTile;
      for (std::size_t i = 0; i < seen_.size(); ++i) {
        const Seen& s = seen_[i];
        if (s.u_max < u || s.u_min > u + kTile - 1 || s.v_max < v || s.v_min > v + kTile - 1) continue;
        candidates_.push_back(static_cast<std::uint16_t>(i));
      }
    }
  }
  first_.push_back(static_cast<std::uint32_t>(candidates_.size()));
}

Hit ViewCast::cast(int tile_column, int tile_row, double u, double v) const {
  const auto tile = static_cast<std::size_t>(tile_row * tile_columns_ + tile_column);
  const Eigen::Vector3d direction = ray(u, v);
  const Seen* nearest = nullptr;
  Eigen::Vector3d nearest_direction;
  Hit hit;
  hit.depth_m = std::numeric_limits<double>::infinity();
  for (auto i = first_[tile]; i < first_[tile + 1]; ++i) {
    const Seen& seen = seen_[candidates_[i]];
    if (seen.nearest_m >= hit.depth_m) break;
    if (u < seen.u_min || u > seen.u_max || v < seen.v_min || v > seen.v_max) continue;
    const Eigen::Vector3d direction_solid = seen.R_solid_camera * direction;
    const Crossing crossing = cross_solid(seen.shape, seen.half, seen.origin_solid, direction_solid);
    if (!crossing.hit() || crossing.t_in <= 0 || crossing.t_in >= hit.depth_m) continue;
    hit.depth_m = crossing.t_in;
    hit.face = crossing.face;
    nearest = &seen;
    nearest_direction = direction_solid;
  }
  if (nearest == nullptr) return {};
  hit.solid = nearest->index;
  hit.p_solid = nearest->origin_solid + hit.depth_m * nearest_direction;
  return hit;
}

Eigen::Vector3d ViewCast::on_flat_face(int solid, int face, double u, double v) const {
  const Seen& seen = seen_[position_[static_cast<std::size_t>(solid)]];
  const Eigen::Vector3d direction = seen.R_solid_camera * ray(u, v);
  const int axis = face / 2;
  const double plane = face % 2 == 0 ? -seen.half[axis] : seen.half[axis];
  return seen.origin_solid + (plane - seen.origin_solid[axis]) / direction[axis] * direction;
}

}  // namespace meshloop::simulation
