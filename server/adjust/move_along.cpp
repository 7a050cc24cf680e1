#include "server/adjust/move_along.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace meshloop::adjust {
namespace {

/// What is farther outside the part's box does not belong to it: more than the noise of two snapshots and their poses.
constexpr double kOutsideBox_m = 0.015;
/// Of a node's vertices; a patch may have strays where its outline was torn.
constexpr double kInside = 0.97;
/// Fewer measured pixels say nothing, for or against.
constexpr double kEvidence_px = 100;
constexpr double kLeastAgreeing = 0.9;
constexpr double kMostSeenThrough = 0.03;
/// A side that slides in its own plane leaves a strip, in which noise counts for much.
constexpr double kMostStillThere = 0.5;

/// Along the part's axes.
Eigen::AlignedBox3d box_of(const Part& part) {
  Eigen::AlignedBox3d box;
  for (const auto& p : part.submesh.positions) box.extend(part.axes.transpose() * p.cast<double>());
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kOutsideBox_m);
  return {Eigen::Vector3d{box.min() - margin}, Eigen::Vector3d{box.max() + margin}};
}

bool lies_within(const Node& node, const Eigen::AlignedBox3d& box, const Part& part, const Pose& T_part_node) {
  const auto& positions = node.submesh->positions;
  const auto inside = std::count_if(positions.begin(), positions.end(), [&](const Eigen::Vector3f& p) {
    return box.contains(part.axes.transpose() * (T_part_node * p.cast<double>()));
  });
  return static_cast<double>(inside) >= kInside * static_cast<double>(positions.size());
}

bool is_contradicted(const MoveScene& scene, const MoveCheck& check) {
  if (check.seen_px * check.measured < scene.scaled_pixels(kEvidence_px)) return false;
  return check.agreeing < kLeastAgreeing || check.seen_through > kMostSeenThrough ||
         check.still_there > kMostStillThere;
}

}  // namespace

std::optional<AlongPart> moves_along(const MoveScene& scene, const Part& part, const NewPlace& place,
                                     std::size_t node_position) {
  const auto& nodes = scene.snapshot->model->nodes;
  const Node& node = nodes[node_position];
  const Pose T_part_node = nodes[part.node_position].T_world_node.inverse() * node.T_world_node;
  if (!lies_within(node, box_of(part), part, T_part_node)) return std::nullopt;
  AlongPart along;
  along.part = make_part(node, node_position, std::vector<bool>(node.submesh->triangles.size(), true));
  along.without = take_away(scene, along.part);
  along.place.T_camera_node = place.T_camera_node * T_part_node;
  along.place.check = check_move(scene, along.part, along.without, along.place.T_camera_node);
  along.place.confidence = place.confidence;
  if (is_contradicted(scene, along.place.check)) return std::nullopt;
  return along;
}

}  // namespace meshloop::adjust
