#pragma once
// A small z-buffer: what of the model a camera sees, where the comparison's images do not say it.
#include <cstdint>
#include <limits>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/mesh/submesh.h"
#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {

/// The nearest surface behind each pixel of a window; lens distortion is left out.
struct DepthBuffer {
  Window window;
  /// Metres along the optical axis, row by row; 0 where nothing is.
  std::vector<float> z;
  /// What `draw` was told of the triangle that is seen; means nothing where nothing is.
  std::vector<std::uint32_t> what;

  DepthBuffer() = default;
  explicit DepthBuffer(const Window& size) : window{size}, z(size.size(), 0.0F), what(size.size(), 0) {}

  [[nodiscard]] bool contains(int x, int y) const {
    return x >= window.x0 && y >= window.y0 && x < window.x1 && y < window.y1;
  }
  /// The pixel must be in the window.
  [[nodiscard]] static std::size_t position(const Window& window, int x, int y) {
    return static_cast<std::size_t>(y - window.y0) * static_cast<std::size_t>(window.width()) +
           static_cast<std::size_t>(x - window.x0);
  }
  [[nodiscard]] std::size_t at(int x, int y) const { return position(window, x, y); }
  /// 0 outside the window.
  [[nodiscard]] float depth(int x, int y) const { return contains(x, y) ? z[at(x, y)] : 0; }
};

/// For `draw`: the triangle is left out.
inline constexpr std::uint32_t kNotDrawn = std::numeric_limits<std::uint32_t>::max();

/// Draws triangles from either side; `what_of` holds a number for each of them. What is nearer than 5 cm is cut away.
void draw(const Submesh& submesh, const std::vector<std::uint32_t>& what_of, const Pose& T_camera_node,
          const Camera& camera, DepthBuffer& buffer);

/// The pixels that a box of points may cover, and `margin` more to each side, inside the picture: all of it when the
/// box reaches behind the camera; empty when it lies beside the picture.
[[nodiscard]] Window projected_window(const Eigen::AlignedBox3f& box, const Pose& T_camera_node, const Camera& camera,
                                      int margin);

[[nodiscard]] Window common_part(const Window& a, const Window& b);
/// Around both; an empty one adds nothing.
[[nodiscard]] Window around(const Window& a, const Window& b);

}  // namespace meshloop::adjust
