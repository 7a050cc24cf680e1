#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "common/base/hash.h"
#include "common/base/result.h"
#include "common/image/image.h"

namespace meshloop {

using Triangle = std::array<std::uint32_t, 3>;

/// The smallest piece of geometry that is encoded and sent: one indexed triangle mesh, in metres, in its node's frame.
/// Front faces are counter-clockwise seen from outside.
struct Submesh {
  std::vector<Eigen::Vector3f> positions;
  /// One per position, or empty.
  std::vector<Rgb8> colors;
  std::vector<Triangle> triangles;

  [[nodiscard]] bool has_colors() const { return !colors.empty(); }
  [[nodiscard]] Eigen::AlignedBox3f bounds() const;
  /// Bytes of positions (12 each), colours (3 each) and indices (12 a triangle): what an uncompressed update would
  /// send.
  [[nodiscard]] std::size_t raw_bytes() const;
};

/// Largest mesh that is accepted from a file or from the network.
inline constexpr std::size_t kMaxVertices = 16'000'000;
inline constexpr std::size_t kMaxTriangles = 32'000'000;

/// Refuses what later stages could not work with: no triangles, an index out of range, a position that is not finite
/// or farther than 10 km from the origin, colours that do not match.
[[nodiscard]] Status validate(const Submesh& submesh);

/// Hash over positions, colours and triangles.
[[nodiscard]] Hash content_hash(const Submesh& submesh);

/// Not all three corners lie on one line.
[[nodiscard]] bool has_area(const Submesh& submesh, const Triangle& triangle);

/// The submesh with only the triangles for which keep[t] is true; vertices that nothing uses are dropped, the others
/// keep their order and their exact bits.
[[nodiscard]] Submesh keep_triangles(const Submesh& submesh, const std::vector<bool>& keep);

/// Area-weighted vertex normals, unit length; (0, 0, 1) where a vertex has no area.
[[nodiscard]] std::vector<Eigen::Vector3f> vertex_normals(const Submesh& submesh);

}  // namespace meshloop
