#include "common/detail/cluster_cut.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace meshloop {
namespace {

constexpr float kStep_m = 0.05f;
constexpr std::size_t kSteps = 400;

/// A view in the submesh's frame: the half spaces whose intersection it is, the depth there, and the eye.
class Frustum {
 public:
  explicit Frustum(const Eigen::Matrix4f& clip) : depth_{clip.row(3).transpose()} {
    for (int axis = 0; axis < 3; ++axis) {
      inside_[static_cast<std::size_t>(2 * axis)] = clip.row(3) + clip.row(axis);
      inside_[static_cast<std::size_t>(2 * axis + 1)] = clip.row(3) - clip.row(axis);
    }
    Eigen::Matrix3f turn;
    turn << clip.row(0).head<3>(), clip.row(1).head<3>(), clip.row(3).head<3>();
    const Eigen::FullPivLU<Eigen::Matrix3f> lu{turn};
    if (lu.isInvertible()) eye_ = lu.solve(-Eigen::Vector3f{clip(0, 3), clip(1, 3), clip(3, 3)});
  }

  /// The near plane cuts nothing off the box, and the eye is behind that plane.
  [[nodiscard]] bool looks_from_outside_at(const Eigen::AlignedBox3f& box) const {
    const Eigen::Vector4f& near = inside_[4];
    return eye_ && near.dot(box.center().homogeneous()) > 0.5f * near.head<3>().cwiseAbs().dot(box.sizes());
  }

  /// All triangles of the cluster face away from the eye.
  [[nodiscard]] bool sees_only_backs(const Cluster& cluster) const {
    const auto& [axis, cutoff] = cluster.normals;
    const Eigen::Vector3f along =
        Eigen::Vector3f{static_cast<float>(axis[0]), static_cast<float>(axis[1]), static_cast<float>(axis[2])} / 127;
    const Eigen::Vector3f to_center = cluster.bounds.center() - *eye_;
    const float radius = 0.5f * cluster.bounds.diagonal().norm();
    return to_center.dot(along) >= static_cast<float>(cutoff) / 127 * to_center.norm() + radius;
  }

  [[nodiscard]] bool leaves_out(const Eigen::AlignedBox3f& box) const {
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
  /// None in a parallel projection.
  std::optional<Eigen::Vector3f> eye_;
};

std::size_t at(std::int32_t position) {
  return static_cast<std::size_t>(position);
}

void find_fine_enough(const ClusterHierarchy& hierarchy, const Tolerance& tolerance, const Frustum& frustum,
                      std::vector<char>& by_group) {
  by_group.clear();
  for (const auto& group : hierarchy.groups) {
    const bool fits = group.error_m <= tolerance.at(frustum.depth(group.bounds));
    by_group.push_back(fits && !tolerance.is_exact() ? 1 : 0);
  }
}

void find_seen_from_outside(const ClusterHierarchy& hierarchy, const Tolerance& tolerance, const Frustum& frustum,
                            std::vector<char>& by_part) {
  by_part.clear();
  for (const auto& box : hierarchy.closed_parts) {
    by_part.push_back(!tolerance.is_exact() && frustum.looks_from_outside_at(box) ? 1 : 0);
  }
}

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
  const Frustum frustum{view.clip_from_mesh};
  find_fine_enough(hierarchy, *view.tolerance, frustum, is_fine_enough_);
  find_seen_from_outside(hierarchy, *view.tolerance, frustum, is_seen_from_outside_);
  ranges_.clear();
  // Of a group that is too coarse the members are shown, unless they are too coarse as well.
  const auto show = [&](std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t m = first; m < first + count; ++m) {
      const Cluster& cluster = hierarchy.clusters[hierarchy.members[m]];
      const bool is_too_coarse = cluster.made_by != Cluster::kNone && is_fine_enough_[at(cluster.made_by)] == 0;
      if (is_too_coarse || frustum.leaves_out(cluster.bounds)) continue;
      const bool may_face_away =
          cluster.closed_part != Cluster::kNone && is_seen_from_outside_[at(cluster.closed_part)] != 0;
      if (may_face_away && frustum.sees_only_backs(cluster)) continue;
      ranges_.push_back({cluster.first_triangle, cluster.triangle_count});
    }
  };
  for (std::size_t i = 0; i < hierarchy.groups.size(); ++i) {
    const ClusterGroup& group = hierarchy.groups[i];
    if (is_fine_enough_[i] != 0 || frustum.leaves_out(group.bounds)) continue;
    show(group.first_member, group.member_count);
  }
  show(hierarchy.first_unreplaced, static_cast<std::uint32_t>(hierarchy.members.size()) - hierarchy.first_unreplaced);
  join_neighbours(ranges_);
  return ranges_;
}

}  // namespace meshloop
