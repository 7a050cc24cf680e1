#include "server/adjust/move_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "common/change/classify_rule.h"

namespace meshloop::adjust {
namespace {

constexpr double kLeastAgreeing = 0.97;
constexpr double kMostSeenThrough = 0.015;
constexpr double kLeastMeasured = 0.6;
constexpr double kMostHidden = 0.025;
constexpr double kMostOutside = 0.03;
constexpr double kLeastExplained = 0.96;
constexpr double kMostStillThere = 0.1;
/// Of what is seen of the part: less than that left is its outline's noise, and tells nothing.
constexpr double kLeastLeft = 0.02;
/// Of a region, of what is left open when it counts as closed.
constexpr double kMostOpen = 0.1;
/// Loose surface that the part shares so much of its own pixels with is its business.
constexpr double kTouches = 0.03;
constexpr int kReach_px = 2;
constexpr int kMargin_px = 3;

/// The picture with the part at its new place.
struct Hypothesis {
  DepthBuffer part;
  /// `what` is 1 where the part is seen.
  DepthBuffer seen;
  std::vector<float> threshold_m;
};

Hypothesis put_there(const MoveScene& scene, const Part& part, const WithoutPart& without, const Pose& T_camera_node) {
  const Camera& camera = scene.camera();
  Hypothesis put;
  put.part = DepthBuffer{projected_window(part.submesh.bounds(), T_camera_node, camera, kMargin_px)};
  draw(part.submesh, part.counted, T_camera_node, camera, put.part);
  Window window = around(put.part.window, without.old_place.window);
  std::set<std::uint32_t> touched;
  for (int y = put.part.window.y0; y < put.part.window.y1; ++y) {
    for (int x = put.part.window.x0; x < put.part.window.x1; ++x) {
      if (put.part.depth(x, y) > 0 && without.piece(x, y) != 0) touched.insert(without.piece(x, y));
    }
  }
  for (const auto piece : touched) window = around(window, without.pieces[piece - 1].window);
  put.seen = DepthBuffer{window};
  put.threshold_m.assign(window.size(), 0);
  std::size_t i = 0;
  for (int y = window.y0; y < window.y1; ++y) {
    for (int x = window.x0; x < window.x1; ++x, ++i) {
      const float behind = without.background(x, y);
      const float z = put.part.depth(x, y);
      const bool is_part = z > 0 && (!(behind > 0) || z <= behind);
      put.seen.z[i] = is_part ? z : behind;
      put.seen.what[i] = is_part ? 1 : 0;
      put.threshold_m[i] = without.threshold_m(x, y);
      if (!is_part) continue;
      const auto normal = normal_of(part, T_camera_node, put.part.what[put.part.at(x, y)]);
      put.threshold_m[i] =
          static_cast<float>(scene.tolerance.at(camera.back_project(x, y, static_cast<double>(z)), normal));
    }
  }
  return put;
}

/// By the comparison's own rule; what continues the pixel's surface is no other surface.
Label label_at(const MoveScene& scene, const Hypothesis& put, int x, int y) {
  const DepthBuffer& seen = put.seen;
  const std::size_t i = seen.at(x, y);
  const float measured = scene.measured(x, y);
  const float threshold = put.threshold_m[i];
  const float z = seen.z[i];
  float nearest = z;
  float farthest = z;
  bool has_gap = false;
  if (rule::needs_neighbourhood(measured, z, threshold)) {
    for (int dy = -kReach_px; dy <= kReach_px; ++dy) {
      for (int dx = -kReach_px; dx <= kReach_px; ++dx) {
        if (!seen.contains(x + dx, y + dy)) continue;
        const std::size_t n = seen.at(x + dx, y + dy);
        const float other = seen.z[n];
        has_gap = has_gap || !(other > 0);
        const bool continues = seen.what[n] == seen.what[i] && std::abs(other - z) <= threshold;
        if (continues || !(other > 0)) continue;
        nearest = nearest > 0 ? std::min(nearest, other) : other;
        farthest = std::max(farthest, other);
      }
    }
  }
  return static_cast<Label>(rule::classify(measured, z, threshold, nearest, farthest, has_gap));
}

/// Pixels.
struct Counts {
  double covered = 0;
  double hidden = 0;
  double seen = 0;
  double measured = 0;
  double agreeing = 0;
  double seen_through = 0;
  double decided = 0;
  double left = 0;
  double still_there = 0;
};

struct PieceCounts {
  double of_part = 0;
  double of_nothing = 0;
};

double share(double part, double all, double of_none) {
  return all > 0 ? part / all : of_none;
}

void count_at(const MoveScene& scene, const WithoutPart& without, const Hypothesis& put, int x, int y, Label label,
              Counts& counts, std::map<std::uint32_t, PieceCounts>& pieces) {
  const std::size_t i = put.seen.at(x, y);
  const bool is_part = put.seen.what[i] == 1;
  const float z = put.part.depth(x, y);
  if (z > 0) {
    ++counts.covered;
    const float behind = without.background(x, y);
    if (!is_part && behind > 0 && z > behind + std::min(without.threshold_m(x, y), 0.05F)) ++counts.hidden;
  }
  const bool is_decided = label != Label::unmeasured && label != Label::undecided;
  if (is_part) {
    ++counts.seen;
    if (label != Label::unmeasured) ++counts.measured;
    if (is_decided) ++counts.decided;
    if (label == Label::agrees) ++counts.agreeing;
    if (label == Label::farther) ++counts.seen_through;
  } else if (is_decided && without.in_footprint(x, y)) {
    ++counts.left;
    const float old_z = without.old_place.depth(x, y);
    const bool as_before = std::abs(scene.measured(x, y) - old_z) <= scene.threshold_m(x, y);
    if (is_change(label) && as_before) ++counts.still_there;
  }
  const auto piece = without.piece(x, y);
  if (piece == 0 || !is_decided) return;
  if (is_part && label == Label::agrees) {
    ++pieces[piece].of_part;
  } else if (is_change(label)) {
    ++pieces[piece].of_nothing;
  }
}

// The least, over the pieces that the part has a share in.
double share_explained(const std::map<std::uint32_t, PieceCounts>& pieces, double part_pixels) {
  double least = 1;
  bool any = false;
  for (const auto& [piece, counts] : pieces) {
    if (counts.of_part < kTouches * part_pixels) continue;
    any = true;
    least = std::min(least, counts.of_part / (counts.of_part + counts.of_nothing));
  }
  return any ? least : 0;
}

std::vector<RegionId> closed_regions(const MoveScene& scene, const MoveCheck& check) {
  std::map<RegionId, std::pair<double, double>> open_and_all;
  for (int y = 0; y < scene.open.height(); ++y) {
    for (int x = 0; x < scene.open.width(); ++x) {
      const RegionId id = scene.open(x, y);
      if (id == 0) continue;
      auto& [open, all] = open_and_all[id];
      ++all;
      const Window& w = check.window;
      const bool inside = x >= w.x0 && y >= w.y0 && x < w.x1 && y < w.y1;
      if (!inside || check.is_explained[DepthBuffer::position(w, x, y)] == 0) ++open;
    }
  }
  std::vector<RegionId> closed;
  for (const auto& [id, pixels] : open_and_all) {
    const bool was_closed = std::find(scene.closed.begin(), scene.closed.end(), id) != scene.closed.end();
    if (!was_closed && pixels.first <= kMostOpen * pixels.second) closed.push_back(id);
  }
  return closed;
}

}  // namespace

double share_outside(const MoveScene& scene, const Part& part, const Pose& T_camera_node) {
  double all = 0;
  double outside = 0;
  for (const auto& [point, normal] : part.points) {
    const Eigen::Vector3d p = T_camera_node * point;
    const double facing = -(T_camera_node.linear() * normal).dot(p) / p.norm();
    if (facing <= 0) continue;
    all += facing;
    if (!(p.z() > 0.05) || !scene.camera().contains(scene.camera().project(p))) outside += facing;
  }
  return share(outside, all, 1);
}

MoveCheck check_move(const MoveScene& scene, const Part& part, const WithoutPart& without, const Pose& T_camera_node) {
  const Hypothesis put = put_there(scene, part, without, T_camera_node);
  MoveCheck check;
  check.window = put.seen.window;
  check.expected = put.seen.z;
  check.threshold_m = put.threshold_m;
  check.node_index.assign(check.window.size(), 0);
  check.is_explained.assign(check.window.size(), 0);
  Counts counts;
  std::map<std::uint32_t, PieceCounts> pieces;
  std::size_t i = 0;
  for (int y = check.window.y0; y < check.window.y1; ++y) {
    for (int x = check.window.x0; x < check.window.x1; ++x, ++i) {
      const Label label = label_at(scene, put, x, y);
      count_at(scene, without, put, x, y, label, counts, pieces);
      check.node_index[i] =
          put.seen.what[i] == 1 ? static_cast<std::uint32_t>(part.node_position + 1) : without.node_index(x, y);
      const RegionId region = scene.open(x, y);
      if (region != 0) check.is_explained[i] = kind_of(label) != scene.kind_of_region(region) ? 1 : 0;
    }
  }
  check.agreeing = share(counts.agreeing, counts.decided, 0);
  check.seen_through = share(counts.seen_through, counts.decided, 1);
  check.measured = share(counts.measured, counts.seen, 0);
  check.seen_px = counts.seen;
  check.hidden = share(counts.hidden, counts.covered, 1);
  check.still_there = share(counts.still_there, std::max(counts.left, kLeastLeft * counts.seen), 0);
  check.explained = share_explained(pieces, counts.seen);
  check.outside = share_outside(scene, part, T_camera_node);
  check.closes = closed_regions(scene, check);
  return check;
}

std::optional<std::string> MoveCheck::refusal() const {
  const auto percent = [](double value) { return fmt::format("{:.1f} %", 100 * value); };
  if (agreeing < kLeastAgreeing) return "only " + percent(agreeing) + " of it agree";
  if (seen_through > kMostSeenThrough) return percent(seen_through) + " of it are seen through";
  if (measured < kLeastMeasured) return "only " + percent(measured) + " of it are measured";
  if (hidden > kMostHidden) return percent(hidden) + " of it are hidden";
  if (outside > kMostOutside) return percent(outside) + " of it are outside the picture";
  if (explained < kLeastExplained) return "only " + percent(explained) + " of the loose surface are explained";
  if (still_there > kMostStillThere) return percent(still_there) + " of its old place still show it";
  if (closes.empty()) return "it closes no region";
  return std::nullopt;
}

}  // namespace meshloop::adjust
