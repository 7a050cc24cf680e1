#include "server/adjust/grid_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "common/base/connected.h"

namespace meshloop::adjust {
namespace {

const Camera kCamera{64, 48, 60, 60, 31.5, 23.5, {}};

// Surfaces at 1 and 2 m with holes, a rim here and there.
DepthGrid random_grid(std::uint32_t seed, int width, int height) {
  std::mt19937 random{seed};
  std::normal_distribution<float> noise{0, 0.004f};
  DepthGrid grid;
  grid.window = {3, 5, 3 + width, 5 + height};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool there = random() % 8 != 0;
      const bool far = (x / 7 + y / 5) % 2 == 0;
      grid.z.push_back(there ? (far ? 2.0f : 1.0f) + noise(random) : 0.0f);
      grid.sigma.push_back(there ? 0.004f : 0.0f);
      grid.role.push_back(!there ? Role::outside : random() % 6 == 0 ? Role::rim : Role::member);
    }
  }
  return grid;
}

bool on_one_surface(const DepthGrid& grid, std::uint32_t a, std::uint32_t b) {
  const auto w = static_cast<std::uint32_t>(grid.window.width());
  const double pixels = std::hypot(double(a % w) - double(b % w), double(a / w) - double(b / w));
  const auto nearer = grid.z[a] < grid.z[b] ? a : b;
  return grid.z[a] > 0 && grid.z[b] > 0 &&
         std::abs(grid.z[a] - grid.z[b]) <=
             grid.z[nearer] * kSteepest / kCamera.fx * pixels + 4 * grid.sigma[nearer] + 1e-6;
}

TEST(GridMesh, JoinsWhatIsOnOneSurface) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const auto grid = random_grid(seed, 40 + static_cast<int>(seed), 30);
    const auto triangles = triangles_of(join_pixels(grid, kCamera, 4, {}));
    ASSERT_GT(triangles.size(), 500U);
    const auto w = static_cast<std::uint32_t>(grid.window.width());
    for (const auto& [a, b, c] : triangles) {
      EXPECT_TRUE(on_one_surface(grid, a, b) && on_one_surface(grid, b, c) && on_one_surface(grid, c, a));
      EXPECT_TRUE(is_part(grid.role[a]) || is_part(grid.role[b]) || is_part(grid.role[c]));
      const auto x = [w](std::uint32_t i) { return static_cast<int>(i % w); };
      const auto y = [w](std::uint32_t i) { return static_cast<int>(i / w); };
      // Counter-clockwise as seen, rows going down: half a pixel.
      EXPECT_EQ((x(b) - x(a)) * (y(c) - y(a)) - (y(b) - y(a)) * (x(c) - x(a)), -1);
    }
  }
}

TEST(GridMesh, LeavesNoBlockOpen) {
  DepthGrid grid = random_grid(1, 30, 20);
  std::fill(grid.z.begin(), grid.z.end(), 1.5f);
  std::fill(grid.sigma.begin(), grid.sigma.end(), 0.004f);
  std::fill(grid.role.begin(), grid.role.end(), Role::member);
  EXPECT_EQ(triangles_of(join_pixels(grid, kCamera, 4, {})).size(), 2U * 29U * 19U);
  grid.z[5 * 30 + 7] = 0;  // four blocks lose a corner, and one triangle each
  grid.role[5 * 30 + 7] = Role::outside;
  EXPECT_EQ(triangles_of(join_pixels(grid, kCamera, 4, {})).size(), 2U * 29U * 19U - 4U);
}

TEST(GridMesh, TakesTheDiagonalThatLiesOnALine) {
  DepthGrid grid;
  grid.window = {0, 0, 2, 2};
  grid.z = {1.0f, 1.001f, 1.001f, 1.0f};  // the falling diagonal is flatter
  grid.sigma = {0.004f, 0.004f, 0.004f, 0.004f};
  grid.role.assign(4, Role::member);
  EXPECT_EQ(triangles_of(join_pixels(grid, kCamera, 4, {})), (std::vector<Triangle>{{0, 2, 3}, {0, 3, 1}}));
  EXPECT_EQ(triangles_of(join_pixels(grid, kCamera, 4, {0, 1, 1, 0})), (std::vector<Triangle>{{0, 2, 1}, {1, 2, 3}}));
  EXPECT_EQ(triangles_of(join_pixels(grid, kCamera, 4, {0, 1, kCornerOfLines, 0})),
            (std::vector<Triangle>{{0, 2, 1}, {1, 2, 3}}));
}

TEST(GridMesh, DropsPiecesThatShareNoVertexWithMore) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const auto grid = random_grid(seed, 50, 40);
    GridMesh mesh = join_pixels(grid, kCamera, 4, {});
    auto expected = triangles_of(mesh);
    Connected connected{grid.z.size()};
    for (const auto& [a, b, c] : expected) {
      connected.join(a, b);
      connected.join(b, c);
    }
    std::map<std::uint32_t, std::size_t> count;
    for (const auto& t : expected) ++count[connected.first_of(t[0])];
    const std::size_t smallest = 10 + seed;
    std::erase_if(expected, [&](const Triangle& t) { return count[connected.first_of(t[0])] < smallest; });
    drop_small_pieces(mesh, smallest);
    EXPECT_EQ(triangles_of(mesh), expected) << seed;
  }
}

TEST(GridMesh, NumbersTheCornersOfItsTriangles) {
  const GridMesh mesh = join_pixels(random_grid(3, 33, 21), kCamera, 4, {});
  const auto vertices = number_vertices(mesh);
  const auto by_pixel = triangles_of(mesh);
  const auto by_number = triangles_of(mesh, vertices);
  ASSERT_EQ(by_pixel.size(), by_number.size());
  std::vector<bool> used(vertices.pixels.size(), false);
  for (std::size_t t = 0; t < by_pixel.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_LT(by_number[t][k], vertices.pixels.size());
      EXPECT_EQ(vertices.pixels[by_number[t][k]], by_pixel[t][k]);
      used[by_number[t][k]] = true;
    }
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
}

TEST(GridMesh, OfAPixelOrALineIsEmpty) {
  for (const auto& [w, h] : {std::pair{1, 1}, std::pair{1, 9}, std::pair{9, 1}}) {
    GridMesh mesh = join_pixels(random_grid(1, w, h), kCamera, 4, {});
    drop_small_pieces(mesh, 1);
    EXPECT_TRUE(triangles_of(mesh).empty());
    EXPECT_TRUE(number_vertices(mesh).pixels.empty());
  }
}

}  // namespace
}  // namespace meshloop::adjust
