#include "server/adjust/color_projection.h"

#include <algorithm>

#include "common/base/target_clones.h"

namespace meshloop::adjust {

// What is chosen between is computed on both sides, so that no loop has a branch. What is read is copied first: the
// compiler cannot know that it is not written to.

MESHLOOP_TARGET_CLONES
void project_points(const ColorView& view, const Eigen::Vector3f* points_depth, std::size_t count,
                    ProjectedPoints& projected) {
  const ColorView c = view;
  const auto& R = c.R_color_depth;
  const float r00 = R(0, 0), r01 = R(0, 1), r02 = R(0, 2), t0 = c.t_color_depth.x();
  const float r10 = R(1, 0), r11 = R(1, 1), r12 = R(1, 2), t1 = c.t_color_depth.y();
  const float r20 = R(2, 0), r21 = R(2, 1), r22 = R(2, 2), t2 = c.t_color_depth.z();
  const float last_u = static_cast<float>(c.width) - 0.5f;
  const float last_v = static_cast<float>(c.height) - 0.5f;
  const auto last_column = static_cast<float>(c.columns - 1);
  const auto last_row = static_cast<float>(c.rows - 1);
  const float* p = points_depth->data();
  for (std::size_t i = 0; i < count; ++i) {
    const float x = p[3 * i];
    const float y = p[3 * i + 1];
    const float z = p[3 * i + 2];
    const float z_color = r20 * x + r21 * y + r22 * z + t2;
    const float per_z = 1 / z_color;
    const float u = c.fx * (r00 * x + r01 * y + r02 * z + t0) * per_z + c.cx;
    const float v = c.fy * (r10 * x + r11 * y + r12 * z + t1) * per_z + c.cy;
    const bool is_inside = (z_color > 0.01f) & (u >= -0.5f) & (v >= -0.5f) & (u <= last_u) & (v <= last_v);
    projected.u[i] = is_inside ? u : 0.0f;
    projected.v[i] = is_inside ? v : 0.0f;
    projected.z[i] = z_color;
    projected.inside[i] = is_inside ? 1 : 0;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const float column = std::min(std::max(projected.u[i] * c.scale + 0.5f, 0.0f), last_column);
    const float row = std::min(std::max(projected.v[i] * c.scale + 0.5f, 0.0f), last_row);
    projected.cell[i] = static_cast<std::int32_t>(row) * c.columns + static_cast<std::int32_t>(column);
  }
}

MESHLOOP_TARGET_CLONES
void project_row(const ColorView& view, const Eigen::Vector3f& first, const Eigen::Vector3f& along, const float* z,
                 std::size_t count, const ProjectedRow& projected) {
  const float fx = view.fx * view.scale;
  const float fy = view.fy * view.scale;
  const float cx = view.cx * view.scale;
  const float cy = view.cy * view.scale;
  const float first_x = first.x(), first_y = first.y(), first_z = first.z();
  const float along_x = along.x(), along_y = along.y(), along_z = along.z();
  const float t_x = view.t_color_depth.x(), t_y = view.t_color_depth.y(), t_z = view.t_color_depth.z();
  float* u = projected.u;
  float* v = projected.v;
  float* z_color = projected.z_color;
  for (std::size_t x = 0; x < count; ++x) {
    const auto column = static_cast<float>(static_cast<int>(x));
    const float p_x = (first_x + along_x * column) * z[x] + t_x;
    const float p_y = (first_y + along_y * column) * z[x] + t_y;
    const float p_z = (first_z + along_z * column) * z[x] + t_z;
    const float per_z = 1 / p_z;
    u[x] = fx * p_x * per_z + cx;
    v[x] = fy * p_y * per_z + cy;
    z_color[x] = z[x] > 0 ? p_z : -1.0f;
  }
}

MESHLOOP_TARGET_CLONES
void find_corners(const ColorView& view, const ProjectedPoints& projected, std::size_t count, PixelCorners& corners) {
  const auto last_u = static_cast<float>(view.width - 1);
  const auto last_v = static_cast<float>(view.height - 1);
  const int width = view.width;
  const int last_left = view.width - 2;
  const int last_top = view.height - 2;
  for (std::size_t i = 0; i < count; ++i) {
    const float u = std::min(std::max(projected.u[i], 0.0f), last_u) * kUnitsPerPixel + 0.5f;
    const float v = std::min(std::max(projected.v[i], 0.0f), last_v) * kUnitsPerPixel + 0.5f;
    const auto u_units = static_cast<std::int32_t>(u);
    const auto v_units = static_cast<std::int32_t>(v);
    const std::int32_t x = std::min(u_units / kUnitsPerPixel, last_left);
    const std::int32_t y = std::min(v_units / kUnitsPerPixel, last_top);
    corners.top_left[i] = y * width + x;
    corners.right_units[i] = u_units - x * kUnitsPerPixel;
    corners.down_units[i] = v_units - y * kUnitsPerPixel;
  }
}

}  // namespace meshloop::adjust
