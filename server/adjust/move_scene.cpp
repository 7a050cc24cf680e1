#include "server/adjust/move_scene.h"

#include <algorithm>
#include <cmath>

namespace meshloop::adjust {
namespace {

constexpr double kSigmas = 3;
constexpr double kSteepest_rad = 1.45;
/// A pixel measures over its whole area.
constexpr double kFootprint_px = 0.288675;  // 1 / sqrt(12)

}  // namespace

Tolerance::Tolerance(const Snapshot& snapshot)
    : camera_{&snapshot.rig->depth},
      sensor_{&snapshot.rig->sensor},
      position_variance_m2_{snapshot.depth_pose.covariance.topLeftCorner<3, 3>().trace() / 3},
      angle_variance_{snapshot.depth_pose.covariance.bottomRightCorner<3, 3>().trace() / 3} {}

double Tolerance::at(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
  const double z = point.z();
  const Eigen::Vector3d ray = point / z;
  const double along = std::max(std::abs(normal.dot(ray)), 1e-3 * ray.norm());
  const double theta = std::min(std::acos(std::min(along / ray.norm(), 1.0)), kSteepest_rad);
  const double slope_m_per_px = z * std::hypot(normal.x() / camera_->fx, normal.y() / camera_->fy) / along;
  const double lateral_m = slope_m_per_px * std::max(sensor_->sigma_lateral_px(theta), kFootprint_px);
  const double axial_m = sensor_->sigma_z_m(z, theta);
  const double pose_m2 = position_variance_m2_ + z * z * angle_variance_;
  return kSigmas * std::sqrt(axial_m * axial_m + lateral_m * lateral_m + pose_m2);
}

MoveScene::MoveScene(const Snapshot& seen)
    : snapshot{&seen},
      tolerance{seen},
      expected{seen.comparison->expected},
      node_index{seen.comparison->node_index},
      threshold_m{seen.comparison->threshold_m},
      open{seen.regions->ids} {
  RegionId known = 0;
  for (auto& id : open.pixels()) {
    if (id == 0 || id == known) continue;
    if (kind_of_region(id) == ChangeKind::none) {
      id = 0;
    } else {
      known = id;
    }
  }
}

float MoveScene::measured(int x, int y) const {
  const float z = snapshot->frame->depth(x, y);
  return z > 0 && z < 1e6F ? z : 0;
}

ChangeKind MoveScene::kind_of_region(RegionId id) const {
  const auto& regions = snapshot->regions->regions;
  const auto found =
      std::find_if(regions.begin(), regions.end(), [id](const Region& region) { return region.id == id; });
  return found != regions.end() && found->confirmed ? found->kind : ChangeKind::none;
}

double MoveScene::scaled_pixels(double pixels) const {
  return pixels * camera().width * camera().height / (640.0 * 480.0);
}

Eigen::Vector3d normal_of(const Part& part, const Pose& T_camera_node, std::uint32_t triangle) {
  const auto& [a, b, c] = part.submesh.triangles[triangle];
  const auto& p = part.submesh.positions;
  const Eigen::Vector3d first = (p[b] - p[a]).cast<double>();
  const Eigen::Vector3d second = (p[c] - p[a]).cast<double>();
  return T_camera_node.linear() * first.cross(second).normalized();
}

}  // namespace meshloop::adjust
