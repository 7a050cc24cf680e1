#include "server/adjust/part_outline.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace meshloop::adjust {
namespace {

constexpr double kLeastGap_m = 0.02;
/// A measurement this near to the part's edge in depth may be of it.
constexpr double kMayBePart_m = 0.05;
/// So many pixels without a measurement may lie on the edge; where there are more, a shadow begins at it.
constexpr int kLargestHole_px = 3;

/// What lies at a pixel near the edge.
enum class Found { part, nothing, other };

Found look(const MoveScene& scene, const WithoutPart& without, const Eigen::Vector2d& pixel, double z) {
  const auto x = static_cast<int>(std::floor(pixel.x() + 0.5));
  const auto y = static_cast<int>(std::floor(pixel.y() + 0.5));
  if (x < 0 || y < 0 || x >= scene.camera().width || y >= scene.camera().height) return Found::nothing;
  const auto measured = static_cast<double>(scene.measured(x, y));
  if (!(measured > 0)) return Found::nothing;
  return without.piece(x, y) != 0 && std::abs(measured - z) < kMayBePart_m ? Found::part : Found::other;
}

// Steps across the edge: the last pixel that is the part's, as an offset outwards.
std::optional<double> find_edge(const MoveScene& scene, const WithoutPart& without, const Eigen::Vector2d& pixel,
                                const Eigen::Vector2d& outwards, double z, int reach_px) {
  const auto at = [&](int k) { return look(scene, without, pixel + k * outwards, z); };
  int last = 0;
  if (at(0) == Found::part) {
    while (last < reach_px && at(last + 1) == Found::part) ++last;
    if (last == reach_px) return std::nullopt;
  } else {
    while (last > -reach_px && at(last) != Found::part) --last;
    if (at(last) != Found::part) return std::nullopt;
  }
  int hole = 0;
  while (hole <= kLargestHole_px && at(last + 1 + hole) == Found::nothing) ++hole;
  if (hole > kLargestHole_px) return last;
  // Past a hole the part may go on.
  if (at(last + 1 + hole) == Found::part) return std::nullopt;
  return last + hole / 2.0;
}

// From the pixels around that the part does not cover; nothing inside, and at thin places.
std::optional<Eigen::Vector2d> outwards_at(const DepthBuffer& drawn, int x, int y) {
  if (drawn.depth(x - 1, y) > 0 && drawn.depth(x + 1, y) > 0 && drawn.depth(x, y - 1) > 0 && drawn.depth(x, y + 1) > 0)
    return std::nullopt;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int dy = -3; dy <= 3; ++dy) {
    for (int dx = -3; dx <= 3; ++dx) {
      if (drawn.depth(x + dx, y + dy) > 0) sum -= Eigen::Vector2d{dx, dy};
    }
  }
  if (sum.norm() < 4) return std::nullopt;
  return sum.normalized();
}

bool stands_free(const MoveScene& scene, const WithoutPart& without, const Eigen::Vector2d& pixel,
                 const Eigen::Vector2d& outwards, double z) {
  for (const int k : {0, 2}) {
    const auto x = static_cast<int>(std::lround(pixel.x() + k * outwards.x()));
    const auto y = static_cast<int>(std::lround(pixel.y() + k * outwards.y()));
    if (x < 0 || y < 0 || x >= scene.camera().width || y >= scene.camera().height) return false;
    const auto behind = static_cast<double>(without.background(x, y));
    if (behind > 0 && behind - z < kLeastGap_m + 3 * static_cast<double>(without.threshold_m(x, y))) return false;
  }
  return true;
}

}  // namespace

std::vector<OutlinePoint> find_outline(const MoveScene& scene, const Part& part, const WithoutPart& without,
                                       const Pose& T_camera_node, int reach_px) {
  const Camera& camera = scene.camera();
  DepthBuffer drawn{projected_window(part.submesh.bounds(), T_camera_node, camera, 1)};
  draw(part.submesh, part.counted, T_camera_node, camera, drawn);
  std::vector<OutlinePoint> outline;
  for (int y = drawn.window.y0; y < drawn.window.y1; ++y) {
    for (int x = drawn.window.x0; x < drawn.window.x1; ++x) {
      const auto z = static_cast<double>(drawn.depth(x, y));
      if (!(z > 0) || x < 2 || y < 2 || x + 2 >= camera.width || y + 2 >= camera.height) continue;
      const auto outwards = outwards_at(drawn, x, y);
      const Eigen::Vector2d pixel{x, y};
      if (!outwards || !stands_free(scene, without, pixel, *outwards, z)) continue;
      const auto off = find_edge(scene, without, pixel, *outwards, z, reach_px);
      if (off) outline.push_back({camera.back_project(x, y, z), *outwards, *off});
    }
  }
  return outline;
}

}  // namespace meshloop::adjust
