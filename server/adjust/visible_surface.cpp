#include "server/adjust/visible_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {
namespace {

constexpr double kSmallestTolerance_m = 0.002;
constexpr double kSame_m = 0.01;
constexpr int kSilhouette_px = 2;

}  // namespace

VisibleSurface::VisibleSurface(const Snapshot& snapshot) : snapshot_{&snapshot} {
  for (const auto& region : snapshot.regions->regions) {
    if (region.confirmed && region.kind == ChangeKind::removal) removal_ids_.push_back(region.id);
  }
  std::sort(removal_ids_.begin(), removal_ids_.end());
  start_evidence();
  for (int i = 0; i < kSilhouette_px; ++i) grow_evidence();
  find_evidence_window();
}

void VisibleSurface::start_evidence() {
  evidence_ = snapshot_->regions->ids;
  threshold_m_ = snapshot_->comparison->threshold_m;
  RegionId known = 0;
  for (auto& id : evidence_.pixels()) {
    if (id == 0 || id == known) continue;
    if (std::binary_search(removal_ids_.begin(), removal_ids_.end(), id)) {
      known = id;
    } else {
      id = 0;
    }
  }
}

void VisibleSurface::find_evidence_window() {
  constexpr int kMargin_px = 3;
  Window box{evidence_.width(), evidence_.height(), 0, 0};
  for (int y = 0; y < evidence_.height(); ++y) {
    for (int x = 0; x < evidence_.width(); ++x) {
      if (evidence_(x, y) == 0) continue;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1), std::max(box.y1, y + 1)};
    }
  }
  if (box.empty()) return;
  evidence_window_ = {std::max(0, box.x0 - kMargin_px), std::max(0, box.y0 - kMargin_px),
                      std::min(evidence_.width(), box.x1 + kMargin_px),
                      std::min(evidence_.height(), box.y1 + kMargin_px)};
}

void VisibleSurface::grow_evidence() {
  if (removal_ids_.empty()) return;
  const Comparison& c = *snapshot_->comparison;
  const Image<RegionId> before = evidence_;
  for (int y = 1; y + 1 < before.height(); ++y) {
    for (int x = 1; x + 1 < before.width(); ++x) {
      if (c.labels(x, y) != Label::undecided || before(x, y) != 0 || c.node_index(x, y) == 0) continue;
      for (int k = 0; k < 9; ++k) {
        const int nx = x + k % 3 - 1;
        const int ny = y + k / 3 - 1;
        if (before(nx, ny) == 0 || c.node_index(nx, ny) != c.node_index(x, y)) continue;
        evidence_(x, y) = before(nx, ny);
        threshold_m_(x, y) = threshold_m_(nx, ny);
        break;
      }
    }
  }
}

std::vector<std::size_t> VisibleSurface::nodes_in_removal_regions() const {
  const auto ids = evidence_.pixels();
  const auto nodes = snapshot_->comparison->node_index.pixels();
  std::vector<bool> seen(snapshot_->model->nodes.size(), false);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] != 0 && nodes[i] != 0 && nodes[i] <= seen.size()) seen[nodes[i] - 1] = true;
  }
  std::vector<std::size_t> positions;
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (seen[n]) positions.push_back(n);
  }
  return positions;
}

// The gradient is the smaller of the two one-sided differences on the same node, so that a silhouette does not count as
// a slope; and no surface is steeper than 80 degrees.
double VisibleSurface::tolerance(int x, int y) const {
  const Comparison& c = *snapshot_->comparison;
  const Camera& camera = snapshot_->rig->depth;
  const double z = c.expected(x, y);
  const auto difference = [&](int nx, int ny, double steepest) {
    const bool inside = nx >= 0 && ny >= 0 && nx < camera.width && ny < camera.height;
    if (!inside || c.node_index(nx, ny) != c.node_index(x, y)) return steepest;
    return std::min(steepest, std::abs(c.expected(nx, ny) - z));
  };
  const double across = z * kSteepest / camera.fx;
  const double down = z * kSteepest / camera.fy;
  const double gradient = std::min(difference(x - 1, y, across), difference(x + 1, y, across)) +
                          std::min(difference(x, y - 1, down), difference(x, y + 1, down));
  return std::max(kSmallestTolerance_m, 3 * gradient);
}

bool VisibleSurface::shows(int x, int y, std::uint32_t node_index, double z) const {
  const Comparison& c = *snapshot_->comparison;
  return c.node_index(x, y) == node_index && std::abs(c.expected(x, y) - z) <= tolerance(x, y);
}

// Unmeasured is never evidence.
bool VisibleSurface::is_seen_through(int x, int y, double z) const {
  const double measured = snapshot_->frame->depth(x, y);
  return evidence_(x, y) != 0 && measured > 0 && measured - z > threshold_m_(x, y);
}

bool VisibleSurface::is_expected(int x, int y, std::size_t node_position, double z) const {
  const Comparison& c = *snapshot_->comparison;
  return c.node_index(x, y) == node_position + 1 && std::abs(c.expected(x, y) - z) <= kSame_m;
}

Sighting VisibleSurface::look_at(const Eigen::Vector3d& p_world, std::size_t node_position) const {
  const Eigen::Vector3d p = snapshot_->depth_pose.T_camera_world * p_world;
  if (!(p.z() > 0.01)) return {};
  const Camera& camera = snapshot_->rig->depth;
  const Eigen::Vector2d pixel = camera.project(p);
  if (!camera.contains(pixel)) return {};
  const auto node_index = static_cast<std::uint32_t>(node_position + 1);
  // The nearest pixel first. At a silhouette it may show what lies behind: then the next nearest of the four around.
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  const int other_x = pixel.x() > x ? x + 1 : x - 1;
  const int other_y = pixel.y() > y ? y + 1 : y - 1;
  const std::array<std::array<int, 2>, 4> around{{{x, y}, {other_x, y}, {x, other_y}, {other_x, other_y}}};
  bool hidden = true;
  for (const auto& [u, v] : around) {
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    if (shows(u, v, node_index, p.z())) return {Sight::clear, is_seen_through(u, v, p.z()) ? evidence_(u, v) : 0};
    const double expected = snapshot_->comparison->expected(u, v);
    hidden = hidden && expected > 0 && p.z() > expected + tolerance(u, v);
  }
  return {hidden ? Sight::hidden : Sight::clear, 0};
}

}  // namespace meshloop::adjust
