#include "common/simulation/room.h"

#include <array>
#include <cmath>
#include <memory>

#include "common/simulation/random.h"
#include "common/simulation/texture.h"

namespace meshloop::simulation {
namespace {

constexpr double kHalfWidth_m = 7;
constexpr double kFloor_m = -2.9;
constexpr double kCeiling_m = 2.0;
constexpr double kPixel_m = 0.012;
constexpr Rgb8 kPlaster{214, 206, 192};
constexpr Rgb8 kFloorLight{150, 124, 98};
constexpr Rgb8 kFloorDark{112, 88, 68};
constexpr std::array<Rgb8, 8> kPaints{{{176, 62, 48},
                                       {46, 84, 122},
                                       {222, 178, 84},
                                       {62, 104, 82},
                                       {236, 230, 214},
                                       {94, 66, 104},
                                       {206, 120, 66},
                                       {40, 44, 54}}};

/// A rectangle on a wall, metres: x from the wall's left end, z above the eye.
struct Panel {
  double left, right, bottom, top;
  [[nodiscard]] bool contains(double x, double z) const { return x > left && x < right && z > bottom && z < top; }
  [[nodiscard]] double to_edge(double x, double z) const {
    return std::min({x - left, right - x, z - bottom, top - z});
  }
};

Rgb8 paint(std::uint64_t random) {
  return kPaints[random % kPaints.size()];
}

// Rectangles of colour that overlap, in a dark frame with a white mount.
Rgb8 picture(const Panel& panel, double x, double z, std::uint64_t seed) {
  const double to_edge = panel.to_edge(x, z);
  if (to_edge < 0.06) return {52, 40, 32};
  if (to_edge < 0.16) return {238, 234, 224};
  const double s = (x - panel.left) / (panel.right - panel.left);
  const double t = (z - panel.bottom) / (panel.top - panel.bottom);
  Rgb8 color = blended(paint(seed), kPlaster, 0.4 + 0.3 * t);
  for (std::uint64_t i = 0; i < 7; ++i) {
    const double centre_s = random_unit(seed, i, 1);
    const double centre_t = random_unit(seed, i, 2);
    const double size = 0.10 + 0.22 * random_unit(seed, i, 3);
    const bool round = random_unit(seed, i, 4) < 0.4;
    const double ds = std::abs(s - centre_s);
    const double dt = std::abs(t - centre_t);
    if (round ? std::hypot(ds, dt) < size * 0.7 : ds < size && dt < size * 0.6) color = paint(random_bits(seed, i, 5));
  }
  return color;
}

// Sky and hills behind bars.
Rgb8 window(const Panel& panel, double x, double z) {
  if (panel.to_edge(x, z) < 0.09) return {244, 242, 238};
  const double middle = 0.5 * (panel.left + panel.right);
  if (std::abs(x - middle) < 0.04 || std::abs(z - 0.5 * (panel.bottom + panel.top)) < 0.035) return {244, 242, 238};
  const double hill = panel.bottom + 0.55 + 0.18 * std::sin(1.9 * x) + 0.08 * std::sin(5.3 * x + 1);
  if (z < hill) return blended({96, 128, 84}, {148, 168, 116}, (z - panel.bottom) / 0.9);
  return blended({214, 230, 242}, {142, 186, 226}, (z - panel.bottom) / (panel.top - panel.bottom));
}

// Boards with books of random width, height and colour.
Rgb8 shelf(const Panel& panel, double x, double z, std::uint64_t seed) {
  constexpr double kBoard_m = 0.42;
  constexpr double kBook_m = 0.075;
  if (panel.to_edge(x, z) < 0.05) return {122, 92, 64};
  const double level = std::floor((z - panel.bottom) / kBoard_m);
  const double above_board = z - panel.bottom - level * kBoard_m;
  if (above_board < 0.045) return {132, 100, 70};
  const double book = std::floor((x - panel.left) / kBook_m);
  const std::uint64_t random =
      random_bits(seed, static_cast<std::uint64_t>(book), static_cast<std::uint64_t>(level) + 11);
  const bool gap = random % 9 == 0;
  const double height = 0.22 + 0.13 * to_unit(mix(random));
  if (gap || above_board > height) return {62, 48, 38};
  const double in_book = (x - panel.left) / kBook_m - book;
  const double round = 0.75 + 0.25 * std::sin(3.14159 * in_book);
  const bool label = std::abs(above_board - 0.16) < 0.03 && in_book > 0.2 && in_book < 0.8;
  return label ? Rgb8{232, 222, 190} : scaled(paint(random >> 8), round);
}

Rgb8 wall_color(int wall, double x, double z, std::uint64_t seed) {
  const double rise = (z - kFloor_m) / (kCeiling_m - kFloor_m);
  const Rgb8 plaster = scaled(kPlaster, 0.74 + 0.16 * rise + 0.03 * std::sin(0.9 * x + wall));
  if (z < kFloor_m + 0.22) return {226, 222, 212};
  const std::uint64_t wall_seed = mix(seed + static_cast<std::uint64_t>(wall));
  constexpr std::array<Panel, 3> kPictures{{{1.2, 3.0, -1.9, -0.6}, {4.0, 5.3, -1.6, 0.1}, {11.2, 12.9, -1.8, -0.7}}};
  for (std::size_t i = 0; i < kPictures.size(); ++i) {
    if (kPictures[i].contains(x, z)) return picture(kPictures[i], x, z, mix(wall_seed + i));
  }
  const Panel wide = wall % 2 == 0 ? Panel{6.3, 10.2, kFloor_m + 0.22, 0.2} : Panel{6.6, 9.8, -1.9, 0.6};
  if (!wide.contains(x, z)) return plaster;
  return wall % 2 == 0 ? shelf(wide, x, z, wall_seed) : window(wide, x, z);
}

Bitmap paint_wall(int wall, std::uint64_t seed) {
  Bitmap bitmap(2 * kHalfWidth_m, kCeiling_m - kFloor_m, kPixel_m);
  for (int row = 0; row < bitmap.pixels().height(); ++row) {
    for (int column = 0; column < bitmap.pixels().width(); ++column) {
      bitmap.pixels()(column, row) =
          wall_color(wall, (column + 0.5) * kPixel_m, kCeiling_m - (row + 0.5) * kPixel_m, seed);
    }
  }
  return bitmap;
}

Rgb8 floor_color(const Eigen::Vector3d& p, std::uint64_t seed) {
  const double plank = std::floor(p.y() / 0.28);
  const double tone =
      0.5 + 0.22 * smooth_noise(plank * 5.3, p.x() / 2.2, seed) + 0.1 * smooth_noise(p.x(), p.y(), seed);
  const double distance = std::max(std::abs(p.x()), std::abs(p.y())) / kHalfWidth_m;
  return scaled(blended(kFloorLight, kFloorDark, tone), 0.72 + 0.3 * distance);
}

}  // namespace

std::function<Rgb8(const Eigen::Vector3d& direction)> living_room(std::uint64_t seed) {
  auto walls = std::make_shared<std::vector<Bitmap>>();
  for (int wall = 0; wall < 4; ++wall) walls->push_back(paint_wall(wall, seed));
  return [walls, seed](const Eigen::Vector3d& d) -> Rgb8 {
    const double to_wall = kHalfWidth_m / std::max(std::abs(d.x()), std::abs(d.y()));
    const double z = d.z() * to_wall;
    if (z < kFloor_m) return floor_color(d * (kFloor_m / d.z()), seed);
    if (z > kCeiling_m) return scaled({236, 232, 224}, 0.94);
    const bool across_y = std::abs(d.y()) > std::abs(d.x());
    const double along = across_y ? (d.y() > 0 ? d.x() : -d.x()) : (d.x() > 0 ? -d.y() : d.y());
    const std::size_t wall = across_y ? (d.y() > 0 ? 0 : 2) : (d.x() > 0 ? 1 : 3);
    return (*walls)[wall].at(along * to_wall + kHalfWidth_m, kCeiling_m - z);
  };
}

}  // namespace meshloop::simulation
