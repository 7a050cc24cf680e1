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

/// Ranges that follow each other become one.
void join_neighbours(std::vector<TriangleRange>& ranges) {
  std::sort(ranges.begin(), ranges.end(),
            [](const TriangleRange& a, const TriangleRange& b) { return a.first < b.first; });
  std::size_t kept = 0;
  for (const auto& range : ranges) {
    if (kept > 0 && ranges[kept - 1].first + ranges[kept - 1].count == range.first) {
      ranges[kept - 1].count += range.count;
    } else {
      ranges[kept++] = range;
    }
  }
  ranges.resize(kept);
}

}  // namespace

Tolerance::Tolerance(const std::function<double(double)>& rms_m) : steps_(kSteps) {
  double least = rms_m(kStep_m * static_cast<double>(kSteps));
  for (std::size_t i = kSteps; i-- > 0;) {
    least = std::min(least, rms_m(kStep_m * static_cast<double>(i)));
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
  ranges_.clear();
  // Of a group that is too coarse the members are shown, unless they are too coarse as well.
  const auto show = [&](std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t m = first; m < first + count; ++m) {
      const Cluster& cluster = hierarchy.clusters[hierarchy.members[m]];
      const bool is_too_coarse =
          cluster.made_by != Cluster::kNone && is_fine_enough_[static_cast<std::size_t>(cluster.made_by)] == 0;
      if (is_too_coarse || planes.leave_out(cluster.bounds)) continue;
      ranges_.push_back({cluster.first_triangle, cluster.triangle_count});
    }
  };
  for (std::size_t i = 0; i < hierarchy.groups.size(); ++i) {
    const ClusterGroup& group = hierarchy.groups[i];
    if (is_fine_enough_[i] != 0 || planes.leave_out(group.bounds)) continue;
    show(group.first_member, group.member_count);
  }
  show(hierarchy.first_unreplaced, static_cast<std::uint32_t>(hierarchy.members.size()) - hierarchy.first_unreplaced);
  join_neighbours(ranges_);
  return ranges_;
}

}  // namespace meshloop
