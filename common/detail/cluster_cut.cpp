#include "common/detail/cluster_cut.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace meshloop {
namespace {

constexpr float kStep_m = 0.05f;
constexpr std::size_t kSteps = 400;

/// Half spaces in the submesh's frame whose intersection is the view, and the depth there.
class Planes {
 public:
  explicit Planes(const Eigen::Matrix4f& clip) : depth_{clip.row(3).transpose()} {
    for (int axis = 0; axis < 3; ++axis) {
      inside_[static_cast<std::size_t>(2 * axis)] = clip.row(3) + clip.row(axis);
      inside_[static_cast<std::size_t>(2 * axis + 1)] = clip.row(3) - clip.row(axis);
    }
  }

  [[nodiscard]] bool leave_out(const Eigen::AlignedBox3f& box) const {
    const Eigen::Vector4f center = box.center().homogeneous();
    const Eigen::Vector3f half = 0.5f * box.sizes();
    return std::any_of(inside_.begin(), inside_.end(), [&](const Eigen::Vector4f& plane) {
      return plane.dot(center) < -plane.head<3>().cwiseAbs().dot(half);
    });
  }

  /// Of the box's nearest corner.
  [[nodiscard]] float depth(const Eigen::AlignedBox3f& box) const {
    return depth_.dot(box.center().homogeneous()) - 0.5f * depth_.head<3>().cwiseAbs().dot(box.sizes());
  }

 private:
  std::array<Eigen::Vector4f, 6> inside_;
  Eigen::Vector4f depth_;
};

}  // namespace

Tolerance::Tolerance(const std::function<double(double)>& largest_m) : steps_(kSteps) {
  double least = largest_m(kStep_m * static_cast<double>(kSteps));
  for (std::size_t i = kSteps; i-- > 0;) {
    least = std::min(least, largest_m(kStep_m * static_cast<double>(i)));
    steps_[i] = static_cast<float>(least);
  }
}

float Tolerance::at(float depth_m) const {
  if (steps_.empty()) return 0;
  const float step = std::clamp(depth_m / kStep_m, 0.0f, static_cast<float>(kSteps - 1));
  return steps_[static_cast<std::size_t>(step)];
}

const std::vector<TriangleRange>& ClusterCut::choose(const ClusterHierarchy& hierarchy, const CutView& view) {
  const Planes planes{view.clip_from_mesh};
  is_fine_enough_.resize(hierarchy.groups.size());
  for (std::size_t i = 0; i < hierarchy.groups.size(); ++i) {
    const ClusterGroup& group = hierarchy.groups[i];
    const bool fits = group.error_m <= view.tolerance->at(planes.depth(group.bounds));
    is_fine_enough_[i] = fits && !view.tolerance->is_exact() ? 1 : 0;
  }
  const auto fine_enough = [&](std::int32_t group) { return is_fine_enough_[static_cast<std::size_t>(group)] != 0; };
  ranges_.clear();
  for (const auto& cluster : hierarchy.clusters) {
    const bool is_too_coarse = cluster.made_by != Cluster::kNone && !fine_enough(cluster.made_by);
    const bool is_too_fine = cluster.replaced_by != Cluster::kNone && fine_enough(cluster.replaced_by);
    if (is_too_coarse || is_too_fine || planes.leave_out(cluster.bounds)) continue;
    if (!ranges_.empty() && ranges_.back().first + ranges_.back().count == cluster.first_triangle) {
      ranges_.back().count += cluster.triangle_count;
    } else {
      ranges_.push_back({cluster.first_triangle, cluster.triangle_count});
    }
  }
  return ranges_;
}

}  // namespace meshloop
