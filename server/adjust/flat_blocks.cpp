#include "server/adjust/flat_blocks.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace meshloop::adjust {
namespace {

constexpr int kBlocksAcross = 80;
constexpr int kSmallest_px = 4;
constexpr double kLeastMeasured = 0.9;
/// Root mean square distance from the plane, in sigma of one measurement.
constexpr double kFlat_sigmas = 1.4;
/// Pixels that err together.
constexpr double kCorrelated = 10;
/// Of the ray with the normal: 80 degrees.
constexpr double kLeastCosine = 0.17;

/// Least squares of one divided by the depth over a block, which a plane makes linear in the ray's (u, v).
struct Sums {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Vector3d products = Eigen::Vector3d::Zero();
  double inverse_squares = 0;
  int count = 0;
};

Sums sums_of(const DepthImage& depth, const Camera& camera, int x0, int y0, int side) {
  // About the block's corner, in pixels, in single numbers: Eigen's matrices cost more than the sums.
  double s_x = 0, s_y = 0, s_xx = 0, s_xy = 0, s_yy = 0, s_d = 0, s_dx = 0, s_dy = 0, s_dd = 0;
  int count = 0;
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const auto z = static_cast<double>(depth(x0 + i, y0 + j));
      if (!(z > 0.01 && z < 1000)) continue;
      const double d = 1 / z;
      s_x += i, s_y += j, s_xx += i * i, s_xy += i * j, s_yy += j * j;
      s_d += d, s_dx += d * i, s_dy += d * j, s_dd += d * d;
      ++count;
    }
  }
  // To rays: u = (x0 + i - cx) / fx.
  const double u0 = (x0 - camera.cx) / camera.fx;
  const double v0 = (y0 - camera.cy) / camera.fy;
  const double n = count;
  const Eigen::Vector3d one{s_x / camera.fx + n * u0, s_y / camera.fy + n * v0, n};
  Sums sums;
  sums.squares(0, 0) = s_xx / (camera.fx * camera.fx) + 2 * u0 * s_x / camera.fx + n * u0 * u0;
  sums.squares(1, 1) = s_yy / (camera.fy * camera.fy) + 2 * v0 * s_y / camera.fy + n * v0 * v0;
  sums.squares(0, 1) = s_xy / (camera.fx * camera.fy) + u0 * s_y / camera.fy + v0 * s_x / camera.fx + n * u0 * v0;
  sums.squares(1, 0) = sums.squares(0, 1);
  sums.squares.col(2) = one;
  sums.squares.row(2) = one.transpose();
  sums.products << s_dx / camera.fx + u0 * s_d, s_dy / camera.fy + v0 * s_d, s_d;
  sums.inverse_squares = s_dd;
  sums.count = count;
  return sums;
}

Sums operator+(const Sums& a, const Sums& b) {
  return {a.squares + b.squares, a.products + b.products, a.inverse_squares + b.inverse_squares, a.count + b.count};
}

/// A plane through measurements: n . p = 1 for its points p.
struct Plane {
  Eigen::Vector3d n;
  /// Where a ray meets it, and how the surface leans there.
  double z = 0;
  double theta = 0;
  double cosine = 0;
  /// Of one measurement along the axis, m^2: noise across the axis moves a slope along it.
  double variance_m2 = 0;
};

/// Nothing where they bend by more than the noise, or are seen too much from aside.
std::optional<Plane> plane_through(const Sums& sums, const Eigen::Vector3d& ray, const Camera& camera,
                                   const SensorModel& sensor) {
  Plane plane;
  plane.n = sums.squares.ldlt().solve(sums.products);
  const double inverse_z = plane.n.dot(ray);
  if (!(inverse_z > 1e-3) || !plane.n.allFinite()) return std::nullopt;
  plane.z = 1 / inverse_z;
  plane.cosine = plane.n.normalized().dot(ray.normalized());
  if (!(plane.cosine > kLeastCosine)) return std::nullopt;
  plane.theta = std::acos(std::min(1.0, plane.cosine));
  const double z2 = plane.z * plane.z;
  const double lateral_m =
      sensor.sigma_lateral_px(plane.theta) * z2 * std::hypot(plane.n.x() / camera.fx, plane.n.y() / camera.fy);
  plane.variance_m2 = sensor.variance_m2(plane.z, plane.theta, 1) + lateral_m * lateral_m;
  const double left = std::max(0.0, sums.inverse_squares - plane.n.dot(sums.products)) / sums.count;
  if (left * z2 * z2 > kFlat_sigmas * kFlat_sigmas * plane.variance_m2) return std::nullopt;
  return plane;
}

/// `around`: the block and its eight neighbours. Its normal is theirs where all lie on one plane.
std::optional<FlatBlock> make_block(const Sums& own, const Sums& around, const Eigen::Vector3d& ray, int side,
                                    const Camera& camera, const SensorModel& sensor) {
  if (own.count < kLeastMeasured * side * side) return std::nullopt;
  const auto plane = plane_through(own, ray, camera, sensor);
  if (!plane) return std::nullopt;
  FlatBlock block;
  block.point = plane->z * ray;
  const int independent = std::max(1, static_cast<int>(own.count / kCorrelated));
  // A share of the quantisation stays, noise across the axis averages out.
  const double axial_m2 = sensor.variance_m2(plane->z, plane->theta, 1);
  const double variance_m2 =
      sensor.variance_m2(plane->z, plane->theta, independent) + (plane->variance_m2 - axial_m2) / independent;
  const auto wide = plane_through(around, ray, camera, sensor);
  const Eigen::Vector3d n = wide ? wide->n : plane->n;
  block.normal = n.normalized();
  block.sigma_m = std::sqrt(variance_m2) * block.normal.dot(ray);
  // A line through so many measurements, so wide.
  const double width_m = (wide ? 3 : 1) * side * plane->z / camera.fx;
  block.normal_variance = 12 * plane->variance_m2 / ((wide ? around.count : own.count) * width_m * width_m);
  return block;
}

}  // namespace

FlatBlocks::FlatBlocks(const DepthImage& depth, const Camera& camera, const SensorModel& sensor)
    : camera_{&camera},
      side_px_{std::max(kSmallest_px, depth.width() / kBlocksAcross)},
      columns_{depth.width() / side_px_},
      rows_{depth.height() / side_px_},
      positions_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -1) {
  std::vector<Sums> sums;
  sums.reserve(positions_.size());
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      sums.push_back(sums_of(depth, camera, column * side_px_, row * side_px_, side_px_));
    }
  }
  const double middle = (side_px_ - 1) / 2.0;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      Sums around;
      for (int j = std::max(row - 1, 0); j <= std::min(row + 1, rows_ - 1); ++j) {
        for (int i = std::max(column - 1, 0); i <= std::min(column + 1, columns_ - 1); ++i) {
          around = around + sums[static_cast<std::size_t>(j * columns_ + i)];
        }
      }
      const Eigen::Vector3d ray = camera.back_project(column * side_px_ + middle, row * side_px_ + middle, 1);
      const auto block =
          make_block(sums[static_cast<std::size_t>(row * columns_ + column)], around, ray, side_px_, camera, sensor);
      if (!block) continue;
      positions_[static_cast<std::size_t>(row * columns_ + column)] = static_cast<int>(blocks_.size());
      blocks_.push_back(*block);
    }
  }
}

const FlatBlock* FlatBlocks::at(const Eigen::Vector3d& p) const {
  if (!(p.z() > 0.01)) return nullptr;
  const Eigen::Vector2d pixel = camera_->project(p);
  if (!camera_->contains(pixel)) return nullptr;
  const int column = static_cast<int>(pixel.x() + 0.5) / side_px_;
  const int row = static_cast<int>(pixel.y() + 0.5) / side_px_;
  if (column >= columns_ || row >= rows_) return nullptr;
  const int position = positions_[static_cast<std::size_t>(row * columns_ + column)];
  return position < 0 ? nullptr : &blocks_[static_cast<std::size_t>(position)];
}

}  // namespace meshloop::adjust
