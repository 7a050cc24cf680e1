#pragma once
// The triangles between the pixels of a depth grid.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/geometry/camera.h"
#include "common/mesh/submesh.h"
#include "server/adjust/depth_grid.h"

namespace meshloop::adjust {

/// In place of a line's number: a point in which several lines meet.
inline constexpr std::uint16_t kCornerOfLines = 0xffff;

/// Up to two triangles for each block of 2x2 pixels, as a byte at its top left pixel: bits of kBlockTriangles. A
/// block's triangles are on one of its diagonals.
struct GridMesh {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> blocks;
};

/// Corners of the triangle of bit 1 << i: 0 is the block's top left pixel, 1 top right, 2 bottom left, 3 bottom right;
/// counter-clockwise towards the camera.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kBlockTriangles{
    {{0, 2, 3}, {0, 3, 1}, {0, 2, 1}, {1, 2, 3}}};

/// Left out: edges across depth discontinuities (see AdjustOptions), and triangles without a part of the patch.
/// `lines` (empty, or as long as the grid's vectors): of two diagonals the one is taken that joins pixels of one line,
/// which have the same number that is not 0, or kCornerOfLines; else the flatter one.
[[nodiscard]] GridMesh join_pixels(const DepthGrid& grid, const Camera& camera, double discontinuity_sigmas,
                                   const std::vector<std::uint16_t>& lines);

/// Drops the triangles of connected patches (sharing a vertex) with fewer than `smallest` triangles.
void drop_small_pieces(GridMesh& mesh, std::size_t smallest);

/// The pixels that are corners of triangles, numbered row by row.
struct GridVertices {
  std::vector<std::uint32_t> pixels;
  /// As long as the grid; meaningful where a pixel is a vertex.
  std::vector<std::uint32_t> number_of_pixel;
  /// As long as the grid.
  std::vector<std::uint8_t> is_vertex;
};

[[nodiscard]] GridVertices number_vertices(const GridMesh& mesh);

/// Edges with a triangle on one side only, which lies on their left as the camera sees it; pixels, in ascending order.
[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> border_of(const GridMesh& mesh);

/// The triangles of one block, with positions in the grid as indices.
template <class Visit>
void for_each_triangle(const GridMesh& mesh, std::uint32_t block, const Visit& visit) {
  const auto w = static_cast<std::uint32_t>(mesh.width);
  const std::array<std::uint32_t, 4> corners{block, block + 1, block + w, block + w + 1};
  for (std::size_t t = 0; t < kBlockTriangles.size(); ++t) {
    if ((mesh.blocks[block] >> t & 1) == 0) continue;
    const auto& [a, b, c] = kBlockTriangles[t];
    visit(Triangle{corners[a], corners[b], corners[c]});
  }
}

/// With positions in the grid as indices.
[[nodiscard]] std::vector<Triangle> triangles_of(const GridMesh& mesh);
/// With the numbers of vertices as indices.
[[nodiscard]] std::vector<Triangle> triangles_of(const GridMesh& mesh, const GridVertices& vertices);

}  // namespace meshloop::adjust
