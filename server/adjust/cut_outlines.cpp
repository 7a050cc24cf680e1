#include "server/adjust/cut_outlines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "server/adjust/depth_grid.h"
#include "server/adjust/outline.h"

namespace meshloop::adjust {
namespace {

/// Longer triangles are cut: their corners alone say too little of where a region ends.
constexpr double kLarge_px = 8;
/// Around a triangle, so that a line beside it leaves no strip of it.
constexpr int kMargin_px = 3;
/// Silhouettes: a line may lie this far outside the pixels that show the surface.
constexpr int kBeyond_px = 2;
/// Islands and specks below this are noise.
constexpr double kSmallest_px = 10;
constexpr double kNearest_m = 0.01;
constexpr double kSmallestTolerance_m = 0.002;

using Polygon = std::vector<Eigen::Vector3d>;

Polygon clipped(const Polygon& polygon, const Eigen::Vector4d& half_space) {
  Polygon inside;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& a = polygon[i];
    const Eigen::Vector3d& b = polygon[(i + 1) % polygon.size()];
    const double at_a = half_space.dot(a.homogeneous());
    const double at_b = half_space.dot(b.homogeneous());
    if (at_a >= 0) inside.push_back(a);
    if ((at_a >= 0) != (at_b >= 0)) inside.push_back(a + (b - a) * (at_a / (at_a - at_b)));
  }
  return inside;
}

/// The part of a triangle that lies in the picture, in the camera's frame.
Polygon in_picture(const std::array<Eigen::Vector3d, 3>& corners, const Camera& camera) {
  Polygon polygon{corners.begin(), corners.end()};
  const std::array<Eigen::Vector4d, 5> picture{{{0, 0, 1, -kNearest_m},
                                                {camera.fx, 0, camera.cx + 0.5, 0},
                                                {-camera.fx, 0, camera.width - 0.5 - camera.cx, 0},
                                                {0, camera.fy, camera.cy + 0.5, 0},
                                                {0, -camera.fy, camera.height - 0.5 - camera.cy, 0}}};
  for (const auto& half_space : picture) polygon = clipped(polygon, half_space);
  return polygon;
}

/// One triangle's place in the picture.
struct Footprint {
  /// n . p = d in the camera's frame.
  Eigen::Vector3d normal;
  double distance = 0;
  Window window;
  double farthest_m = 0;

  [[nodiscard]] double depth_at(const Camera& camera, int x, int y) const {
    return distance / normal.dot(camera.back_project(x, y, 1));
  }
};

/// Looks at the corners alone.
bool is_small(const std::array<Eigen::Vector3d, 3>& corners, const Camera& camera) {
  Eigen::AlignedBox2d box;
  for (const auto& p : corners) {
    if (!(p.z() > kNearest_m)) return false;
    box.extend(camera.project(p));
  }
  return box.diagonal().norm() <= kLarge_px;
}

/// Nothing for small triangles, and for those beside the picture.
std::optional<Footprint> footprint_of(const std::array<Eigen::Vector3d, 3>& corners, const Camera& camera) {
  if (is_small(corners, camera)) return std::nullopt;
  const Polygon seen = in_picture(corners, camera);
  if (seen.size() < 3) return std::nullopt;
  Footprint footprint;
  footprint.normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  footprint.distance = footprint.normal.dot(corners[0]);
  Eigen::AlignedBox2d box;
  for (const auto& p : seen) {
    box.extend(camera.project(p));
    footprint.farthest_m = std::max(footprint.farthest_m, p.z());
  }
  if (box.diagonal().norm() <= kLarge_px) return std::nullopt;
  const auto clamped = [](double value, int last) { return std::clamp(static_cast<int>(std::floor(value)), 0, last); };
  footprint.window = {
      clamped(box.min().x() - kMargin_px, camera.width), clamped(box.min().y() - kMargin_px, camera.height),
      clamped(box.max().x() + kMargin_px + 1, camera.width), clamped(box.max().y() + kMargin_px + 1, camera.height)};
  return footprint;
}

Window common_part(const Window& a, const Window& b) {
  return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

/// Asks the snapshot's images about the plane of one triangle.
class PlaneInPicture {
 public:
  PlaneInPicture(const Snapshot& snapshot, const VisibleSurface& surface, const Footprint& footprint,
                 std::uint32_t node_index)
      : snapshot_{snapshot}, surface_{surface}, footprint_{footprint}, node_index_{node_index} {}

  /// Looks over the window for what the rest needs: whether some pixel shows the triangle's plane and, by region that
  /// speaks for such a pixel, the window around its pixels, with a margin.
  struct Found {
    bool is_shown = false;
    std::map<RegionId, Window> regions;
  };
  [[nodiscard]] Found look_over(const Window& w) const {
    Found found;
    for (int y = w.y0; y < w.y1; ++y) {
      for (int x = w.x0; x < w.x1; ++x) {
        if (!shows(x, y)) continue;
        found.is_shown = true;
        const RegionId region = surface_.evidence(x, y);
        if (region == 0) continue;
        Window& around = found.regions.try_emplace(region, Window{w.x1, w.y1, w.x0, w.y0}).first->second;
        around = {std::max(w.x0, std::min(around.x0, x - kMargin_px)),
                  std::max(w.y0, std::min(around.y0, y - kMargin_px)),
                  std::min(w.x1, std::max(around.x1, x + kMargin_px + 1)),
                  std::min(w.y1, std::max(around.y1, y + kMargin_px + 1))};
      }
    }
    return found;
  }

  /// Where the region sees through the plane, and a little beyond where the surface ends in the picture. For a window
  /// of the picture.
  [[nodiscard]] Image<std::uint8_t> mask_of(RegionId region, const Window& w) const {
    Image<std::uint8_t> mask{w.width(), w.height()};
    for (int y = 0; y < w.height(); ++y) {
      for (int x = 0; x < w.width(); ++x) {
        mask(x, y) = is_seen_through(x + w.x0, y + w.y0, region) ? 1 : 0;
      }
    }
    for (int i = 0; i < kBeyond_px; ++i) grow(mask, w);
    return mask;
  }

 private:
  [[nodiscard]] bool shows(int x, int y) const {
    const Comparison& c = *snapshot_.comparison;
    if (c.node_index(x, y) != node_index_) return false;
    const double z = footprint_.depth_at(snapshot_.rig->depth, x, y);
    const double tolerance = std::max(kSmallestTolerance_m, snapshot_.rig->sensor.sigma_z_m(z, 0));
    return std::abs(static_cast<double>(c.expected(x, y)) - z) <= tolerance;
  }

  [[nodiscard]] bool is_seen_through(int x, int y, RegionId region) const {
    if (surface_.evidence(x, y) != region || !shows(x, y)) return false;
    return surface_.is_seen_through(x, y, footprint_.depth_at(snapshot_.rig->depth, x, y));
  }

  /// The surface ends here: the pixel shows another one, that does not stand before it.
  [[nodiscard]] bool is_beyond(int x, int y) const {
    if (shows(x, y)) return false;
    const Camera& camera = snapshot_.rig->depth;
    const double expected = snapshot_.comparison->expected(x, y);
    const double z = footprint_.depth_at(camera, x, y);
    return !(expected > 0) || expected > z - std::abs(z) * kSteepest / std::min(camera.fx, camera.fy);
  }

  void grow(Image<std::uint8_t>& mask, const Window& w) const {
    const Image<std::uint8_t> before = mask;
    const auto is_set = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < before.width() && y < before.height() && before(x, y) != 0;
    };
    for (int y = 0; y < mask.height(); ++y) {
      for (int x = 0; x < mask.width(); ++x) {
        if (is_set(x, y)) continue;
        bool has_neighbour = false;
        for (int k = 0; k < 9 && !has_neighbour; ++k) has_neighbour = is_set(x + k % 3 - 1, y + k / 3 - 1);
        if (has_neighbour && is_beyond(x + w.x0, y + w.y0)) mask(x, y) = 1;
      }
    }
  }

  const Snapshot& snapshot_;
  const VisibleSurface& surface_;
  const Footprint& footprint_;
  std::uint32_t node_index_;
};

/// Lines of the window onto the plane, in the node's frame. Near the plane's horizon, where they would leave for the
/// distance, they are cut off beyond the triangle.
std::vector<PlaneLine> lifted(const std::vector<Loop>& loops, const Window& window, const Footprint& footprint,
                              const Camera& camera, const Pose& T_node_camera) {
  constexpr double kFarther = 4;
  // One divided by the depth is linear in the picture.
  const Eigen::Vector3d n = footprint.normal / footprint.distance;
  const Eigen::Vector4d per_depth{n.x() / camera.fx, n.y() / camera.fy, 0,
                                  n.z() - n.x() * camera.cx / camera.fx - n.y() * camera.cy / camera.fy};
  const Eigen::Vector4d before_horizon = per_depth - Eigen::Vector4d{0, 0, 0, 1 / (kFarther * footprint.farthest_m)};
  std::vector<PlaneLine> lines;
  for (const auto& loop : loops) {
    Polygon pixels;
    for (const auto& p : loop) pixels.emplace_back(p.x() + window.x0, p.y() + window.y0, 0);
    PlaneLine line;
    for (const auto& pixel : clipped(pixels, before_horizon)) {
      const double z = 1 / per_depth.dot(pixel.homogeneous());
      line.emplace_back(T_node_camera * camera.back_project(pixel.x(), pixel.y(), z));
    }
    if (line.size() >= 3) lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

LargeTriangles find_cut_outlines(const Snapshot& snapshot, const VisibleSurface& surface, std::size_t node_position) {
  const Node& node = snapshot.model->nodes[node_position];
  const Camera& camera = snapshot.rig->depth;
  const Pose T_camera_node = snapshot.depth_pose.T_camera_world * node.T_world_node;
  LargeTriangles result;
  result.is_large.assign(node.submesh->triangles.size(), false);
  result.is_shown = result.is_large;
  for (std::uint32_t t = 0; t < result.is_large.size(); ++t) {
    std::array<Eigen::Vector3d, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = T_camera_node * node.submesh->positions[node.submesh->triangles[t][k]].cast<double>();
    }
    const auto footprint = footprint_of(corners, camera);
    if (!footprint) continue;
    result.is_large[t] = true;
    const Window window = common_part(footprint->window, surface.evidence_window());
    if (window.empty()) continue;
    const PlaneInPicture plane{snapshot, surface, *footprint, static_cast<std::uint32_t>(node_position + 1)};
    const auto found = plane.look_over(window);
    result.is_shown[t] = found.is_shown;
    for (const auto& [region, around] : found.regions) {
      auto lines = lifted(outline_of(plane.mask_of(region, around), kSmallest_px), around, *footprint, camera,
                          T_camera_node.inverse());
      if (!lines.empty()) result.by_region[region].emplace(t, std::move(lines));
    }
  }
  return result;
}

}  // namespace meshloop::adjust
