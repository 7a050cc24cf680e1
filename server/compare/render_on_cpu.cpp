#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "server/compare/comparator.h"

namespace meshloop {
namespace {

constexpr double kNear_m = 0.05;
constexpr double kFar_m = 50;

using Polygon = std::vector<Eigen::Vector3d>;

// The part of a triangle in front of the near plane: none, three or four corners.
Polygon in_front(const std::array<Eigen::Vector3d, 3>& corners) {
  Polygon kept;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& a = corners[i];
    const Eigen::Vector3d& b = corners[(i + 1) % 3];
    if (a.z() >= kNear_m) kept.push_back(a);
    if ((a.z() >= kNear_m) != (b.z() >= kNear_m)) kept.push_back(a + (kNear_m - a.z()) / (b.z() - a.z()) * (b - a));
  }
  return kept;
}

// Pixel centres on the border count as inside; `sign` is that of the polygon's area in the picture.
bool covers(const std::vector<Eigen::Vector2d>& outline, double sign, const Eigen::Vector2d& pixel) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
    const Eigen::Vector2d to_pixel = pixel - outline[i];
    if (sign * (edge.x() * to_pixel.y() - edge.y() * to_pixel.x()) < 0) return false;
  }
  return true;
}

double doubled_area(const std::vector<Eigen::Vector2d>& outline) {
  double area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    area += a.x() * b.y() - a.y() * b.x();
  }
  return area;
}

struct Targets {
  DepthImage& depth;
  Image<std::uint32_t>& node_index;
};

// Each pixel whose centre lies in the outline gets the depth at which its ray meets the polygon's plane.
void draw(const Polygon& polygon, const Eigen::Vector3d& normal, const Camera& camera, std::uint32_t node,
          const Targets& targets) {
  std::vector<Eigen::Vector2d> outline;
  Eigen::AlignedBox2d box;
  for (const auto& p : polygon) {
    outline.push_back(camera.project(p));
    box.extend(outline.back());
  }
  const double area = doubled_area(outline);
  if (area == 0) return;
  const double plane = normal.dot(polygon.front());
  const auto first = [](double x) { return static_cast<int>(std::ceil(std::max(x, 0.0))); };
  const auto last = [](double x, int size) { return static_cast<int>(std::floor(std::min(x, size - 1.0))); };
  for (int v = first(box.min().y()); v <= last(box.max().y(), camera.height); ++v) {
    for (int u = first(box.min().x()); u <= last(box.max().x(), camera.width); ++u) {
      if (!covers(outline, area, {u, v})) continue;
      const double z = plane / normal.dot(camera.back_project(u, v, 1));
      const float known = targets.depth(u, v);
      if (!(z >= kNear_m && z <= kFar_m) || (known > 0 && known <= static_cast<float>(z))) continue;
      targets.depth(u, v) = static_cast<float>(z);
      targets.node_index(u, v) = node;
    }
  }
}

}  // namespace

void render_on_cpu(const Model& model, const Camera& camera, const Pose& T_camera_world, DepthImage& depth,
                   Image<std::uint32_t>& node_index) {
  depth = DepthImage(camera.width, camera.height);
  node_index = Image<std::uint32_t>(camera.width, camera.height);
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const Node& node = model.nodes[i];
    const Pose T_camera_node = T_camera_world * node.T_world_node;
    for (const auto& triangle : node.submesh->triangles) {
      std::array<Eigen::Vector3d, 3> corners;
      for (std::size_t c = 0; c < 3; ++c) {
        corners[c] = T_camera_node * node.submesh->positions[triangle[c]].cast<double>();
      }
      const Polygon polygon = in_front(corners);
      if (polygon.size() < 3) continue;
      const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      draw(polygon, normal, camera, static_cast<std::uint32_t>(i + 1), {depth, node_index});
    }
  }
}

}  // namespace meshloop
