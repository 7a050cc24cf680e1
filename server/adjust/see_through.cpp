#include "server/adjust/see_through.h"

#include <algorithm>

#include "common/base/median.h"
#include "server/adjust/depth_buffer.h"
#include "server/adjust/visible_surface.h"

namespace meshloop::adjust {
namespace {

/// Of the triangles of a removal, by position: those that go whole or are cut are drawn with their position.
std::vector<std::uint32_t> touched_triangles(const Removal& removal) {
  std::vector<std::uint32_t> numbers(removal.triangles.size(), kNotDrawn);
  for (std::uint32_t t = 0; t < numbers.size(); ++t) {
    if (removal.triangles[t] || removal.cuts.count(t) > 0) numbers[t] = t;
  }
  return numbers;
}

/// Even-odd rule (a ray along the first of the two axes crosses the lines an odd number of times), on the plane as seen
/// along the axis that it faces most. Holes run within their outlines, so that they count out.
bool is_within(const Eigen::Vector3d& p, const std::vector<PlaneLine>& lines, const Eigen::Vector3d& normal) {
  Eigen::Index along = 0;
  normal.cwiseAbs().maxCoeff(&along);
  const Eigen::Index a = (along + 1) % 3;
  const Eigen::Index b = (along + 2) % 3;
  bool within = false;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const auto& from = line[i];
      const auto& to = line[(i + 1) % line.size()];
      if ((from[b] > p[b]) == (to[b] > p[b])) continue;
      const double at = from[a] + (p[b] - from[b]) / (to[b] - from[b]) * (to[a] - from[a]);
      if (p[a] < at) within = !within;
    }
  }
  return within;
}

Eigen::Vector3d normal_of(const Submesh& submesh, std::uint32_t t) {
  const auto& [a, b, c] = submesh.triangles[t];
  const auto& p = submesh.positions;
  return (p[b] - p[a]).cast<double>().cross((p[c] - p[a]).cast<double>());
}

double median_or_zero(std::vector<double> values) {
  return values.empty() ? 0 : median(std::move(values));
}

/// What one look collects over several nodes.
struct Look {
  const Snapshot* snapshot;
  const VisibleSurface* surface;
  SeeThrough sum;
  std::vector<double> behind_m;
  std::vector<double> behind_sigmas;

  void at_pixel(int x, int y) {
    const double expected = snapshot->comparison->expected(x, y);
    const double measured = snapshot->frame->depth(x, y);
    ++sum.visible;
    if (!(measured > 0)) return;
    ++sum.measured;
    if (!surface->is_seen_through(x, y, expected)) return;
    ++sum.seen_through;
    behind_m.push_back(measured - expected);
    behind_sigmas.push_back((measured - expected) / snapshot->rig->sensor.sigma_z_m(measured, 0));
  }

  void at_node(std::size_t position, const Removal& removal) {
    const Node& node = snapshot->model->nodes[position];
    const Camera& camera = snapshot->rig->depth;
    const Pose T_camera_node = snapshot->depth_pose.T_camera_world * node.T_world_node;
    DepthBuffer drawn{projected_window(node.submesh->bounds(), T_camera_node, camera, 0)};
    draw(*node.submesh, touched_triangles(removal), T_camera_node, camera, drawn);
    const Pose T_node_camera = T_camera_node.inverse();
    for (int y = drawn.window.y0; y < drawn.window.y1; ++y) {
      for (int x = drawn.window.x0; x < drawn.window.x1; ++x) {
        const double z = drawn.depth(x, y);
        if (!(z > 0) || !surface->is_expected(x, y, position, z)) continue;
        const std::uint32_t t = drawn.what[drawn.at(x, y)];
        const auto cut = removal.cuts.find(t);
        const bool goes = removal.triangles[t] ||
                          (cut != removal.cuts.end() && is_within(T_node_camera * camera.back_project(x, y, z),
                                                                  cut->second, normal_of(*node.submesh, t)));
        if (goes) at_pixel(x, y);
      }
    }
  }
};

}  // namespace

SeeThrough look_through(const Snapshot& snapshot, const std::vector<Removal>& removals) {
  const VisibleSurface surface{snapshot};
  Look look{&snapshot, &surface, {}, {}, {}};
  const auto& nodes = snapshot.model->nodes;
  for (const auto& removal : removals) {
    const auto node = std::find_if(nodes.begin(), nodes.end(), [&](const Node& n) { return n.id == removal.node; });
    if (node != nodes.end()) look.at_node(static_cast<std::size_t>(node - nodes.begin()), removal);
  }
  look.sum.behind_m = median_or_zero(look.behind_m);
  look.sum.behind_sigmas = median_or_zero(look.behind_sigmas);
  return look.sum;
}

}  // namespace meshloop::adjust
