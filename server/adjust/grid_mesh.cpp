#include "server/adjust/grid_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/base/connected.h"

namespace meshloop::adjust {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// By how much the depth may change from a pixel to the next, if it is the nearer one; -1 where nothing is.
struct Allowance {
  std::vector<float> across;
  std::vector<float> down;
  std::vector<float> slanted;

  explicit Allowance(std::size_t width) : across(width), down(width), slanted(width) {}
};

/// Per metre of depth.
struct Steps {
  float across;
  float down;
  float slanted;
  float sigmas;
};

void fill(Allowance& allowance, const float* z, const float* sigma, const Steps& steps) {
  float* across = allowance.across.data();
  float* down = allowance.down.data();
  float* slanted = allowance.slanted.data();
  const std::size_t width = allowance.across.size();
  for (std::size_t x = 0; x < width; ++x) {  // nothing depends on a branch, so that several are done at once
    const float noise = steps.sigmas * sigma[x];
    const float to_the_side = z[x] * steps.across + noise;
    const float below = z[x] * steps.down + noise;
    const float both = z[x] * steps.slanted + noise;
    across[x] = z[x] > 0 ? to_the_side : -1.0f;
    down[x] = z[x] > 0 ? below : -1.0f;
    slanted[x] = z[x] > 0 ? both : -1.0f;
  }
}

// 1 where pixel a + x and pixel b + x are on one surface.
void join_row(const float* a, const float* b, const float* allowed_a, const float* allowed_b, std::uint8_t* joined,
              std::size_t count) {
  for (std::size_t x = 0; x < count; ++x) {
    const float by_a = allowed_a[x];
    const float by_b = allowed_b[x];
    const float allowed = a[x] < b[x] ? by_a : by_b;
    joined[x] = std::abs(a[x] - b[x]) <= allowed ? 1 : 0;
  }
}

/// Edges and diagonals of one row of blocks: 1 where they do not cross a discontinuity.
struct BlockRow {
  Bytes top;
  Bytes bottom;
  Bytes down;
  Bytes falling;
  Bytes rising;
  /// 1 where of two diagonals the falling one is to be taken.
  Bytes better_falls;

  explicit BlockRow(std::size_t width)
      : top(width), bottom(width), down(width), falling(width), rising(width), better_falls(width) {}
};

void prefer_flatter(const float* top, const float* bottom, Bytes& better_falls) {
  for (std::size_t x = 0; x + 1 < better_falls.size(); ++x)
    better_falls[x] = std::abs(top[x] - bottom[x + 1]) <= std::abs(top[x + 1] - bottom[x]) ? 1 : 0;
}

/// They lie on one straight line; a corner, of which there is one among several lines, lies on each of them.
bool on_one_line(std::uint16_t a, std::uint16_t b) {
  return a != 0 && b != 0 && (a == b || a == kCornerOfLines || b == kCornerOfLines);
}

void prefer_lines(const std::uint16_t* top, const std::uint16_t* bottom, Bytes& better_falls) {
  for (std::size_t x = 0; x + 1 < better_falls.size(); ++x) {
    const bool falls = on_one_line(top[x], bottom[x + 1]);
    if (falls != on_one_line(top[x + 1], bottom[x])) better_falls[x] = falls ? 1 : 0;
  }
}

// Bits of kBlockTriangles, of the diagonal with more triangles.
void choose_triangles(const BlockRow& row, std::uint8_t* blocks) {
  for (std::size_t x = 0; x + 1 < row.top.size(); ++x) {
    const std::uint8_t low_falling = row.falling[x] & row.down[x] & row.bottom[x];
    const std::uint8_t high_falling = row.falling[x] & row.top[x] & row.down[x + 1];
    const std::uint8_t high_rising = row.rising[x] & row.top[x] & row.down[x];
    const std::uint8_t low_rising = row.rising[x] & row.bottom[x] & row.down[x + 1];
    const auto along_falling = static_cast<std::uint8_t>(2 * (low_falling + high_falling) + row.better_falls[x]);
    const auto along_rising = static_cast<std::uint8_t>(2 * (low_rising + high_rising));
    const auto falling = static_cast<std::uint8_t>(low_falling | high_falling << 1);
    const auto rising = static_cast<std::uint8_t>(high_rising << 2 | low_rising << 3);
    blocks[x] = along_falling > along_rising ? falling : rising;
  }
}

// Takes away the triangles none of whose corners is a part of the patch.
void leave_out_rim(const std::uint8_t* top, const std::uint8_t* bottom, std::size_t count, std::uint8_t* blocks) {
  for (std::size_t x = 0; x < count; ++x) {
    const std::uint8_t c0 = top[x];
    const std::uint8_t c1 = top[x + 1];
    const std::uint8_t c2 = bottom[x];
    const std::uint8_t c3 = bottom[x + 1];
    const auto parts =
        static_cast<std::uint8_t>((c0 | c2 | c3) | (c0 | c3 | c1) << 1 | (c0 | c2 | c1) << 2 | (c1 | c2 | c3) << 3);
    blocks[x] = static_cast<std::uint8_t>(blocks[x] & parts);
  }
}

Bytes parts_of(const DepthGrid& grid) {
  Bytes parts(grid.role.size());
  std::transform(grid.role.begin(), grid.role.end(), parts.begin(),
                 [](Role role) -> std::uint8_t { return is_part(role) ? 1 : 0; });
  return parts;
}

/// Which triangles have a corner, as bits; by the corner.
constexpr std::array<std::uint8_t, 4> kTrianglesOfCorner = [] {
  std::array<std::uint8_t, 4> triangles{};
  for (unsigned t = 0; t < 4; ++t) {
    for (const auto corner : kBlockTriangles[t]) {
      auto& those = triangles[corner];
      those = static_cast<std::uint8_t>(those | 1U << t);
    }
  }
  return triangles;
}();

bool has_corner(std::uint8_t block, std::size_t corner) {
  return (block & kTrianglesOfCorner[corner]) != 0;
}

std::uint8_t triangle_count(std::uint8_t block) {
  return static_cast<std::uint8_t>((block & 1) + (block >> 1 & 1) + (block >> 2 & 1) + (block >> 3));
}

}  // namespace

GridMesh join_pixels(const DepthGrid& grid, const Camera& camera, double discontinuity_sigmas,
                     const std::vector<std::uint16_t>& lines) {
  GridMesh mesh{grid.window.width(), grid.window.height(), Bytes(grid.window.size(), 0)};
  if (mesh.width < 2 || mesh.height < 2) return mesh;
  const Steps steps{static_cast<float>(kSteepest / camera.fx), static_cast<float>(kSteepest / camera.fy),
                    static_cast<float>(kSteepest * std::hypot(1 / camera.fx, 1 / camera.fy)),
                    static_cast<float>(discontinuity_sigmas)};
  const auto w = static_cast<std::size_t>(mesh.width);
  const Bytes parts = parts_of(grid);
  Allowance above{w};
  Allowance below{w};
  BlockRow row{w};
  fill(below, grid.z.data(), grid.sigma.data(), steps);
  join_row(grid.z.data(), grid.z.data() + 1, below.across.data(), below.across.data() + 1, row.bottom.data(), w - 1);
  for (std::size_t y = 0; y + 1 < static_cast<std::size_t>(mesh.height); ++y) {
    const float* top = grid.z.data() + y * w;
    const float* bottom = top + w;
    std::swap(above, below);
    std::swap(row.top, row.bottom);
    fill(below, bottom, grid.sigma.data() + (y + 1) * w, steps);
    join_row(bottom, bottom + 1, below.across.data(), below.across.data() + 1, row.bottom.data(), w - 1);
    join_row(top, bottom, above.down.data(), below.down.data(), row.down.data(), w);
    join_row(top, bottom + 1, above.slanted.data(), below.slanted.data() + 1, row.falling.data(), w - 1);
    join_row(top + 1, bottom, above.slanted.data() + 1, below.slanted.data(), row.rising.data(), w - 1);
    prefer_flatter(top, bottom, row.better_falls);
    if (!lines.empty()) prefer_lines(lines.data() + y * w, lines.data() + (y + 1) * w, row.better_falls);
    std::uint8_t* blocks = mesh.blocks.data() + y * w;
    choose_triangles(row, blocks);
    leave_out_rim(parts.data() + y * w, parts.data() + (y + 1) * w, w - 1, blocks);
  }
  return mesh;
}

namespace {

/// Connected patches of a mesh, found row by row. Number 0 is none.
class Pieces {
 public:
  explicit Pieces(const GridMesh& mesh) : width_(static_cast<std::size_t>(mesh.width)), number_(mesh.blocks.size(), 0) {
    for (std::size_t i = 0; i + width_ + 1 < mesh.blocks.size(); ++i) {
      if (mesh.blocks[i] != 0) add(i, mesh.blocks[i]);
    }
    for (std::uint32_t n = 1; n < triangles_.size(); ++n) {
      const auto first = connected_.first_of(n);
      if (first != n) triangles_[first] += triangles_[n];
    }
  }

  /// Of the patch that has this pixel as a corner.
  [[nodiscard]] std::uint32_t triangles_at(std::size_t pixel) {
    return triangles_[connected_.first_of(number_[pixel])];
  }
  [[nodiscard]] std::uint32_t fewest_triangles() {
    std::uint32_t fewest = ~0U;
    for (std::uint32_t n = 1; n < triangles_.size(); ++n) fewest = std::min(fewest, triangles_[connected_.first_of(n)]);
    return fewest;
  }

 private:
  void add(std::size_t i, std::uint8_t block) {
    std::uint32_t* top = number_.data() + i;
    std::uint32_t* bottom = top + width_;
    const std::uint32_t count = triangle_count(block);
    if (count == 2 && top[0] != 0 && top[0] == top[1] && top[0] == bottom[0]) {  // most blocks
      bottom[1] = top[0];
      triangles_[top[0]] += 2;
      return;
    }
    const std::array<std::uint32_t*, 4> corners{top, top + 1, bottom, bottom + 1};
    std::uint32_t number = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      if (!has_corner(block, c) || *corners[c] == 0) continue;
      if (number != 0) connected_.join(number, *corners[c]);
      number = connected_.first_of(*corners[c]);
    }
    if (number == 0) {
      number = connected_.add();
      triangles_.push_back(0);
    }
    for (std::size_t c = 0; c < 4; ++c) {
      if (has_corner(block, c)) *corners[c] = number;
    }
    triangles_[number] += count;
  }
  std::size_t width_;
  std::vector<std::uint32_t> number_;
  Connected connected_{1};
  std::vector<std::uint32_t> triangles_{0};
};

/// Both triangles along a diagonal, as bits.
constexpr unsigned kFalling = 3;
constexpr unsigned kRising = 12;

/// The triangles of a row of blocks are written to `next`, of which the end is returned; `first` is the first block.
template <class NumberOf>
Triangle* write_row(const GridMesh& mesh, std::uint32_t first, const NumberOf& number_of, Triangle* next) {
  const auto w = static_cast<std::uint32_t>(mesh.width);
  for (std::uint32_t i = first; i < first + w; ++i) {
    const unsigned block = mesh.blocks[i];
    if (block == 0) continue;
    const std::uint32_t c0 = number_of(i);
    const std::uint32_t c1 = number_of(i + 1);
    const std::uint32_t c2 = number_of(i + w);
    const std::uint32_t c3 = number_of(i + w + 1);
    if (block == kFalling || block == kRising) {  // most blocks; which of the two is as good as random: no branch
      const bool falls = block == kFalling;
      next[0] = {c0, c2, falls ? c3 : c1};
      next[1] = {falls ? c0 : c1, falls ? c3 : c2, falls ? c1 : c3};
      next += 2;
      continue;
    }
    const std::array<std::uint32_t, 4> corners{c0, c1, c2, c3};
    for (unsigned left = block; left != 0; left &= left - 1) {
      const auto& [a, b, c] = kBlockTriangles[static_cast<std::size_t>(std::countr_zero(left))];
      *next++ = {corners[a], corners[b], corners[c]};
    }
  }
  return next;
}

template <class NumberOf>
std::vector<Triangle> list_triangles(const GridMesh& mesh, const NumberOf& number_of) {
  std::size_t count = 0;
  for (const auto block : mesh.blocks) count += triangle_count(block);
  std::vector<Triangle> triangles;
  triangles.reserve(count);
  std::vector<Triangle> row(2 * static_cast<std::size_t>(mesh.width));
  for (std::uint32_t first = 0; first < mesh.blocks.size(); first += static_cast<std::uint32_t>(mesh.width))
    triangles.insert(triangles.end(), row.data(), write_row(mesh, first, number_of, row.data()));
  return triangles;
}

/// Triangles of a block with that side of it, as bits.
constexpr unsigned kAtTop = 0b0110;
constexpr unsigned kAtBottom = 0b1001;
constexpr unsigned kAtLeft = 0b0101;
constexpr unsigned kAtRight = 0b1010;

// Marks the corners `left` and `right` of a row of blocks.
template <std::size_t left, std::size_t right>
void mark_corners(const std::uint8_t* blocks, std::uint8_t* is_vertex, std::size_t width) {
  for (std::size_t x = 0; x < width; ++x) is_vertex[x] = has_corner(blocks[x], left) || is_vertex[x] != 0;
  for (std::size_t x = 1; x < width; ++x) is_vertex[x] = has_corner(blocks[x - 1], right) || is_vertex[x] != 0;
}

}  // namespace

void drop_small_pieces(GridMesh& mesh, std::size_t smallest) {
  Pieces pieces{mesh};
  if (pieces.fewest_triangles() >= smallest) return;
  for (std::size_t i = 0; i < mesh.blocks.size(); ++i) {
    if (mesh.blocks[i] == 0) continue;
    const std::size_t corner = has_corner(mesh.blocks[i], 0) ? i : i + 1;  // every triangle has one of the two
    if (pieces.triangles_at(corner) < smallest) mesh.blocks[i] = 0;
  }
}

GridVertices number_vertices(const GridMesh& mesh) {
  GridVertices vertices;
  const std::size_t size = mesh.blocks.size();
  const auto w = static_cast<std::size_t>(mesh.width);
  vertices.is_vertex.assign(size, 0);
  for (std::size_t y = 0; y < static_cast<std::size_t>(mesh.height); ++y) {
    const std::uint8_t* below = mesh.blocks.data() + y * w;
    mark_corners<0, 1>(below, vertices.is_vertex.data() + y * w, w);
    if (y > 0) mark_corners<2, 3>(below - w, vertices.is_vertex.data() + y * w, w);
  }
  vertices.number_of_pixel.resize(size);
  vertices.pixels.resize(size);
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < size; ++i) {  // without a branch: the next vertex overwrites what is none
    vertices.number_of_pixel[i] = count;
    vertices.pixels[count] = i;
    count += vertices.is_vertex[i];
  }
  vertices.pixels.resize(count);
  return vertices;
}

std::vector<std::array<std::uint32_t, 2>> border_of(const GridMesh& mesh) {
  const auto w = static_cast<std::uint32_t>(mesh.width);
  std::vector<std::array<std::uint32_t, 2>> border;
  for (std::uint32_t i = 0; i < mesh.blocks.size(); ++i) {
    const unsigned block = mesh.blocks[i];
    if (block == 0) continue;
    const unsigned above = i < w ? 0 : mesh.blocks[i - w];
    const unsigned before = i == 0 ? 0 : mesh.blocks[i - 1];
    const unsigned after = mesh.blocks[i + 1];  // the last column and row have no blocks
    const unsigned below = mesh.blocks[i + w];
    if ((block & kAtTop) != 0 && (above & kAtBottom) == 0) border.push_back({i + 1, i});
    if ((block & kAtLeft) != 0 && (before & kAtRight) == 0) border.push_back({i, i + w});
    if ((block & kAtBottom) != 0 && (below & kAtTop) == 0) border.push_back({i + w, i + w + 1});
    if ((block & kAtRight) != 0 && (after & kAtLeft) == 0) border.push_back({i + w + 1, i + 1});
    if (block == kFalling || block == kRising) continue;
    if ((block & kFalling) == 1) border.push_back({i + w + 1, i});
    if ((block & kFalling) == 2) border.push_back({i, i + w + 1});
    if ((block & kRising) == 4) border.push_back({i + w, i + 1});
    if ((block & kRising) == 8) border.push_back({i + 1, i + w});
  }
  std::sort(border.begin(), border.end());
  return border;
}

std::vector<Triangle> triangles_of(const GridMesh& mesh) {
  return list_triangles(mesh, [](std::uint32_t pixel) { return pixel; });
}

std::vector<Triangle> triangles_of(const GridMesh& mesh, const GridVertices& vertices) {
  return list_triangles(mesh, [&](std::uint32_t pixel) { return vertices.number_of_pixel[pixel]; });
}

}  // namespace meshloop::adjust
