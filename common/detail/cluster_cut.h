#pragma once
// Which clusters of a hierarchy a picture shows.
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/detail/cluster_hierarchy.h"

namespace meshloop {

/// How far a drawn surface may lie from the model's as root mean square, by its depth in the picture; single points may
/// by kLargestPerError times as much. Without a function: every triangle is drawn.
class Tolerance {
 public:
  /// Nothing may differ.
  Tolerance() = default;
  /// `rms_m` gives metres for a depth in metres and does not fall with it (what is used at a depth is the least of
  /// all farther ones); it is looked up every 5 cm as far as 20 m, and counts as constant beyond.
  explicit Tolerance(const std::function<double(double)>& rms_m);

  [[nodiscard]] bool is_exact() const { return steps_.empty(); }
  /// Never more than the function's value. Depths below zero count as zero.
  [[nodiscard]] float at(float depth_m) const;

 private:
  std::vector<float> steps_;
};

struct CutView {
  /// From the submesh's frame to GL clip space, whose w is the depth in metres; all that lies outside is left out.
  Eigen::Matrix4f clip_from_mesh = Eigen::Matrix4f::Identity();
  /// Not null.
  const Tolerance* tolerance = nullptr;
};

/// Triangles that lie one after the other in ClusterHierarchy::triangles.
struct TriangleRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// Clusters that touch the view, in the detail that the tolerance asks for. With an exact tolerance all that touch it;
/// else none that only shows the far side of a closed part. One thread; keeps its memory.
class ClusterCut {
 public:
  /// Valid until the next call.
  [[nodiscard]] const std::vector<TriangleRange>& choose(const ClusterHierarchy& hierarchy, const CutView& view);

 private:
  std::vector<char> is_fine_enough_;
  std::vector<char> is_seen_from_outside_;
  std::vector<TriangleRange> ranges_;
};

}  // namespace meshloop
