#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/base/hash.h"
#include "common/base/result.h"
#include "common/image/image.h"
#include "common/mesh/texture.h"

namespace meshloop {

using Triangle = std::array<std::uint32_t, 3>;

/// The smallest piece of geometry that is encoded and sent: one indexed triangle mesh, in metres, in its node's frame.
/// Front faces are counter-clockwise seen from outside.
struct Submesh {
  std::vector<Eigen::Vector3f> positions;
  /// One per position, or empty.
  std::vector<Rgb8> colors;
  std::vector<Triangle> triangles;
  /// Null: none. A submesh has colours at its vertices or a texture, never both.
  std::shared_ptr<const ProjectedTexture> texture = nullptr;

  /// At its vertices.
  [[nodiscard]] bool has_colors() const { return !colors.empty(); }
  [[nodiscard]] Eigen::AlignedBox3f bounds() const;
  /// Bytes of positions (12 each), colours (3 each) and indices (12 a triangle).
  [[nodiscard]] std::size_t geometry_bytes() const;
  /// Those and the texture's pixels (3 each): what an uncompressed update would send.
  [[nodiscard]] std::size_t raw_bytes() const;
};

/// Largest mesh that is accepted from a file or from the network.
inline constexpr std::size_t kMaxVertices = 16'000'000;
inline constexpr std::size_t kMaxTriangles = 32'000'000;

/// Refuses what later stages could not work with: no triangles, an index out of range, a position that is not finite
/// or farther than 10 km from the origin, colours that do not match, a texture beside colours or that `validate` of
/// textures refuses.
[[nodiscard]] Status validate(const Submesh& submesh);

/// Hash over positions, colours, triangles and texture (the JPEG's bytes and the projection).
[[nodiscard]] Hash content_hash(const Submesh& submesh);

namespace detail {
/// In double precision, in which the products of lattice coordinates are exact.
[[nodiscard]] bool has_area_exactly(const Submesh& submesh, const Triangle& triangle);
}  // namespace detail

/// Not all three corners lie on one line. Of most triangles one coordinate of a cross product of floats tells it; thin
/// ones are looked at exactly.
[[nodiscard]] inline bool has_area(const Submesh& submesh, const Triangle& triangle) {
  const Eigen::Vector3f& corner = submesh.positions[triangle[0]];
  const Eigen::Vector3f along = submesh.positions[triangle[1]] - corner;
  const Eigen::Vector3f across = submesh.positions[triangle[2]] - corner;
  const auto differ = [](float a, float b) {
    constexpr float kRounding = 5e-7f;  // of two differences and their product, each 2^-24
    return std::abs(a - b) > kRounding * (std::abs(a) + std::abs(b));
  };
  return differ(along.x() * across.y(), along.y() * across.x()) ||
         differ(along.y() * across.z(), along.z() * across.y()) ||
         differ(along.z() * across.x(), along.x() * across.z()) || detail::has_area_exactly(submesh, triangle);
}

/// The submesh with only the triangles for which keep[t] is true; vertices that nothing uses are dropped, the others
/// keep their order and their exact bits. A texture is shared.
[[nodiscard]] Submesh keep_triangles(Submesh submesh, const std::vector<bool>& keep);

/// The colours of the vertices: their own, or the texture's where they lie; none where the submesh has neither. A
/// texture that cannot be decoded is an error.
[[nodiscard]] Result<std::vector<Rgb8>> vertex_colors(const Submesh& submesh);

/// Area-weighted vertex normals, unit length; (0, 0, 1) where a vertex has no area.
[[nodiscard]] std::vector<Eigen::Vector3f> vertex_normals(const Submesh& submesh);

}  // namespace meshloop
