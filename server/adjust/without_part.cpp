#include "server/adjust/without_part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "common/change/classify_rule.h"

namespace meshloop::adjust {
namespace {

/// Drawing and the comparison's picture of one surface differ by less, whatever the level of detail.
constexpr double kSameSurface_m = 0.004;
constexpr double kOtherSurface_m = 0.05;
/// Neighbouring pixels of one piece.
constexpr float kLargestStep_m = 0.03F;
constexpr double kSmallestPiece_px = 60;
constexpr int kMargin_px = 3;

void find_footprint(const MoveScene& scene, const Part& part, WithoutPart& without) {
  const Pose T_camera_node = scene.T_camera_node(part.node_position);
  without.old_place = DepthBuffer{projected_window(part.submesh.bounds(), T_camera_node, scene.camera(), kMargin_px)};
  DepthBuffer& old_place = without.old_place;
  draw(part.submesh, part.counted, T_camera_node, scene.camera(), old_place);
  without.footprint.assign(old_place.z.size(), 0);
  std::size_t i = 0;
  for (int y = old_place.window.y0; y < old_place.window.y1; ++y) {
    for (int x = old_place.window.x0; x < old_place.window.x1; ++x, ++i) {
      if (!(old_place.z[i] > 0) || scene.node_index(x, y) != part.node_position + 1) continue;
      const auto z = static_cast<double>(old_place.z[i]);
      const double off = std::abs(static_cast<double>(scene.expected(x, y)) - z);
      if (off > kOtherSurface_m) continue;
      const Eigen::Vector3d point = scene.camera().back_project(x, y, z);
      if (off > kSameSurface_m && off > scene.tolerance.at(point, normal_of(part, T_camera_node, old_place.what[i]))) {
        continue;
      }
      without.footprint[i] = 1;
      ++without.footprint_pixels;
    }
  }
}

/// What `draw` leaves out of a node: the part, and what has moved before it.
std::vector<std::uint32_t> what_stays(const MoveScene& scene, const Part& part, std::size_t node_position) {
  const Node& node = scene.snapshot->model->nodes[node_position];
  std::vector<std::uint32_t> what(node.submesh->triangles.size(), static_cast<std::uint32_t>(node_position + 1));
  const auto leave_out = [&](const Part& gone) {
    if (gone.node_position != node_position) return;
    for (std::size_t t = 0; t < what.size(); ++t) {
      if (gone.triangles[t]) what[t] = kNotDrawn;
    }
  };
  leave_out(part);
  for (const auto& moved : scene.moved) leave_out(moved.part);
  return what;
}

/// What is behind the part, where it is seen.
DepthBuffer draw_behind(const MoveScene& scene, const Part& part, const Window& window) {
  DepthBuffer behind{window};
  const auto& nodes = scene.snapshot->model->nodes;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Pose T_camera_node = scene.T_camera_node(n);
    const Window touched = projected_window(nodes[n].submesh->bounds(), T_camera_node, scene.camera(), 1);
    if (common_part(touched, window).empty()) continue;
    draw(*nodes[n].submesh, what_stays(scene, part, n), T_camera_node, scene.camera(), behind);
  }
  for (const auto& [moved, T_camera_node] : scene.moved) {
    const std::vector<std::uint32_t> what(moved.submesh.triangles.size(),
                                          static_cast<std::uint32_t>(moved.node_position + 1));
    draw(moved.submesh, what, T_camera_node, scene.camera(), behind);
  }
  return behind;
}

/// Of the surface that a drawn pixel shows, from its neighbours.
Eigen::Vector3d normal_at(const DepthBuffer& drawn, const Camera& camera, int x, int y) {
  const auto z = static_cast<double>(drawn.depth(x, y));
  const Eigen::Vector3d here = camera.back_project(x, y, z);
  const auto step = [&](int dx, int dy) {
    Eigen::Vector3d best = camera.back_project(x + dx, y + dy, z) - here;
    double least = 1e9;
    for (const int side : {-1, 1}) {
      const auto other = static_cast<double>(drawn.depth(x + side * dx, y + side * dy));
      if (!(other > 0) || std::abs(other - z) >= least) continue;
      least = std::abs(other - z);
      best = side * (camera.back_project(x + side * dx, y + side * dy, other) - here);
    }
    return best;
  };
  return step(1, 0).cross(step(0, 1)).normalized();
}

void put_behind(const MoveScene& scene, const DepthBuffer& behind, WithoutPart& without) {
  const Window& window = without.old_place.window;
  for (int y = window.y0; y < window.y1; ++y) {
    for (int x = window.x0; x < window.x1; ++x) {
      if (!without.in_footprint(x, y)) continue;
      const std::size_t i = behind.at(x, y);
      const float z = behind.z[i];
      without.background(x, y) = z;
      without.node_index(x, y) = z > 0 ? behind.what[i] : 0;
      without.threshold_m(x, y) = 0;
      if (!(z > 0)) continue;
      without.threshold_m(x, y) = static_cast<float>(scene.tolerance.at(
          scene.camera().back_project(x, y, static_cast<double>(z)), normal_at(behind, scene.camera(), x, y)));
    }
  }
}

// Nearer than whatever the model shows at the pixel or beside it.
bool is_loose(const MoveScene& scene, const WithoutPart& without, int x, int y) {
  const float measured = scene.measured(x, y);
  if (!(measured > 0)) return false;
  const float threshold = without.threshold_m(x, y);
  if (threshold >= rule::kNoThreshold_m) return false;
  const DepthImage& background = without.background;
  const auto is_nearer = [&](float z) { return !(z > 0) || measured < z - threshold; };
  if (!is_nearer(background(x, y))) return false;
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, background.height() - 1); ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, background.width() - 1); ++nx) {
      if (!is_nearer(background(nx, ny))) return false;
    }
  }
  return true;
}

/// Gathers the piece around a pixel; `open` marks loose pixels that belong to none yet.
LoosePiece gather(const MoveScene& scene, int x, int y, std::uint32_t number, std::uint32_t open,
                  Image<std::uint32_t>& pieces, std::vector<Eigen::Vector2i>& members) {
  members.assign(1, {x, y});
  pieces(x, y) = number;
  LoosePiece piece;
  for (std::size_t head = 0; head < members.size(); ++head) {
    const Eigen::Vector2i at = members[head];
    const float z = scene.measured(at.x(), at.y());
    piece.center_m += scene.camera().back_project(at.x(), at.y(), static_cast<double>(z));
    piece.window = around(piece.window, {at.x(), at.y(), at.x() + 1, at.y() + 1});
    for (const auto& step : {Eigen::Vector2i{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const Eigen::Vector2i next = at + step;
      if (next.x() < 0 || next.y() < 0 || next.x() >= pieces.width() || next.y() >= pieces.height()) continue;
      if (pieces(next.x(), next.y()) != open) continue;
      if (std::abs(scene.measured(next.x(), next.y()) - z) > kLargestStep_m) continue;
      pieces(next.x(), next.y()) = number;
      members.push_back(next);
    }
  }
  piece.pixels = static_cast<int>(members.size());
  piece.center_m /= piece.pixels;
  return piece;
}

void find_pieces(const MoveScene& scene, WithoutPart& without) {
  constexpr auto kOpen = ~0U;
  const Camera& camera = scene.camera();
  Image<std::uint32_t>& pieces = without.piece;
  pieces = Image<std::uint32_t>{camera.width, camera.height};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) pieces(x, y) = is_loose(scene, without, x, y) ? kOpen : 0;
  }
  std::vector<Eigen::Vector2i> members;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      if (pieces(x, y) != kOpen) continue;
      const auto number = static_cast<std::uint32_t>(without.pieces.size() + 1);
      const LoosePiece piece = gather(scene, x, y, number, kOpen, pieces, members);
      if (piece.pixels >= scene.scaled_pixels(kSmallestPiece_px)) {
        without.pieces.push_back(piece);
      } else {
        for (const auto& at : members) pieces(at.x(), at.y()) = 0;
      }
    }
  }
}

}  // namespace

WithoutPart take_away(const MoveScene& scene, const Part& part) {
  WithoutPart without;
  find_footprint(scene, part, without);
  without.background = scene.expected;
  without.node_index = scene.node_index;
  without.threshold_m = scene.threshold_m;
  if (without.footprint_pixels > 0) {
    put_behind(scene, draw_behind(scene, part, without.old_place.window), without);
  }
  find_pieces(scene, without);
  return without;
}

}  // namespace meshloop::adjust
