#include "common/simulation/light.h"

#include <algorithm>
#include <cmath>

#include "common/simulation/solid_shape.h"

namespace meshloop::simulation {
namespace {

constexpr double kCell_m = 0.02;
constexpr int kCells = 128;
// Blockers that end nearer than this to the surface are the surface's own neighbours in contact with it.
constexpr double kContact_m = 1e-5;

constexpr double kAmbientBelow = 0.34;
constexpr double kAmbientAbove = 0.50;
constexpr double kLamp = 0.58;
constexpr double kFill = 0.24;

int cell_of(double coordinate_m) {
  // Truncation is as good as rounding down here: what would differ is clamped.
  return std::clamp(static_cast<int>(coordinate_m * (1 / kCell_m) + kCells / 2), 0, kCells - 1);
}

}  // namespace

Light::Light(const Scene& scene) {
  for (const Solid& solid : scene.solids) {
    Blocker blocker{};
    blocker.R_solid_world = solid.T_world_solid.linear().transpose();
    blocker.origin_world = solid.T_world_solid.translation();
    blocker.half = solid.size / 2;
    blocker.direction_solid = blocker.R_solid_world * to_lamp_;
    blocker.shape = solid.shape;
    blocker.column_min = blocker.row_min = kCells;
    blocker.column_max = blocker.row_max = -1;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
      const Eigen::Vector3d p = solid.T_world_solid * blocker.half.cwiseProduct(sign);
      blocker.column_min = std::min(blocker.column_min, column_of(p));
      blocker.column_max = std::max(blocker.column_max, column_of(p));
      blocker.row_min = std::min(blocker.row_min, row_of(p));
      blocker.row_max = std::max(blocker.row_max, row_of(p));
    }
    blockers_.push_back(blocker);
  }
  fill_cells();
}

int Light::column_of(const Eigen::Vector3d& p_world) const {
  return cell_of(across_.dot(p_world));
}
int Light::row_of(const Eigen::Vector3d& p_world) const {
  return cell_of(along_.dot(p_world));
}

void Light::fill_cells() {
  std::vector<std::vector<std::uint16_t>> cells(static_cast<std::size_t>(kCells) * kCells);
  for (std::size_t i = 0; i < blockers_.size(); ++i) {
    const Blocker& b = blockers_[i];
    for (int row = b.row_min; row <= b.row_max; ++row) {
      for (int column = b.column_min; column <= b.column_max; ++column) {
        cells[static_cast<std::size_t>(row * kCells + column)].push_back(static_cast<std::uint16_t>(i));
      }
    }
  }
  for (const auto& cell : cells) {
    first_.push_back(static_cast<std::uint32_t>(in_cell_.size()));
    in_cell_.insert(in_cell_.end(), cell.begin(), cell.end());
  }
  first_.push_back(static_cast<std::uint32_t>(in_cell_.size()));
}

bool Light::reaches(const Eigen::Vector3d& p_world, int index) const {
  const auto cell = static_cast<std::size_t>(row_of(p_world) * kCells + column_of(p_world));
  for (auto i = first_[cell]; i < first_[cell + 1]; ++i) {
    if (in_cell_[i] == index) continue;
    const Blocker& b = blockers_[in_cell_[i]];
    const Crossing crossing =
        cross_solid(b.shape, b.half, b.R_solid_world * (p_world - b.origin_world), b.direction_solid);
    if (crossing.hit() && crossing.t_out > kContact_m) return false;
  }
  return true;
}

double Light::brightness(const Eigen::Vector3d& normal_world, bool reached) const {
  const double up = 0.5 + 0.5 * normal_world.z();
  double sum = kAmbientBelow + (kAmbientAbove - kAmbientBelow) * up;
  sum += kFill * std::max(0.0, normal_world.dot(to_fill_));
  if (reached) sum += kLamp * std::max(0.0, normal_world.dot(to_lamp_));
  return sum;
}

}  // namespace meshloop::simulation
