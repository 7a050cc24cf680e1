#include <array>
#include <cmath>
#include <memory>

#include "common/simulation/random.h"
#include "common/simulation/texture.h"

namespace meshloop::simulation {
namespace {

constexpr double kCell_m = 0.034;
constexpr double kPixel_m = 0.001;
constexpr double kRibbonHalf_m = 0.012;
constexpr Rgb8 kWhite{246, 242, 232};
constexpr Rgb8 kNavy{22, 34, 74};
constexpr Rgb8 kRed{196, 30, 44};
constexpr Rgb8 kGold{240, 186, 52};
constexpr Rgb8 kTeal{18, 128, 128};
constexpr Rgb8 kRibbon{226, 170, 40};
constexpr Rgb8 kRibbonEdge{120, 70, 10};

/// What is printed on one cell: position in the cell from 0 to 1, x right, y down; true is ink.
bool is_ink(int motif, std::uint64_t random, double x, double y) {
  constexpr double kMargin = 0.1;
  if (x < kMargin || y < kMargin || x > 1 - kMargin || y > 1 - kMargin) return false;
  const double s = (x - kMargin) / (1 - 2 * kMargin);
  const double t = (y - kMargin) / (1 - 2 * kMargin);
  switch (motif) {
    case 0:
    case 1: {  // like a letter: 4 x 5 blocks of random ink, symmetric for half of them
      auto column = static_cast<unsigned>(s * 4);
      if (motif == 1 && column > 1) column = 3 - column;
      return ((random >> (static_cast<unsigned>(t * 5) * 4 + column)) & 1) != 0;
    }
    case 2:
      return std::hypot(s - 0.5, t - 0.5) < 0.48;
    case 3:
      return (random & 1) != 0 ? s > t : s + t < 1;
    case 4:
      return (s < 0.5) != (t < 0.5);
    case 5:
      return static_cast<int>(((random & 1) != 0 ? s : t) * 5) % 2 == 0;
    default: {
      const double radius = std::hypot(s - 0.5, t - 0.5);
      return radius < 0.48 && radius > 0.26;
    }
  }
}

Rgb8 paper_at(double x, double y, std::uint64_t seed) {
  struct Colors {
    Rgb8 ground, ink;
  };
  constexpr std::array<Colors, 8> kPairs{{{kWhite, kNavy},
                                          {kWhite, kRed},
                                          {kNavy, kWhite},
                                          {kRed, kWhite},
                                          {kNavy, kGold},
                                          {kWhite, kTeal},
                                          {kGold, kNavy},
                                          {kTeal, kWhite}}};
  const auto column = static_cast<std::uint64_t>(x / kCell_m);
  const auto row = static_cast<std::uint64_t>(y / kCell_m);
  const std::uint64_t random = random_bits(seed, column, row);
  const auto& [ground, ink] = kPairs[(random >> 40) % kPairs.size()];
  const auto motif = static_cast<int>((random >> 32) % 7);
  return is_ink(motif, random, x / kCell_m - static_cast<double>(column), y / kCell_m - static_cast<double>(row))
             ? ink
             : ground;
}

// Distance from the middle line of the nearest band of the ribbon: one band around the box across its longer side, one
// across the other.
double to_ribbon(int axis, double x, double y) {
  if (axis == 2) return std::min(std::abs(x), std::abs(y));
  return std::abs(x);
}

Bitmap paint_face(int axis, double width, double height, std::uint64_t seed) {
  Bitmap bitmap(width, height, kPixel_m);
  for (int row = 0; row < bitmap.pixels().height(); ++row) {
    for (int column = 0; column < bitmap.pixels().width(); ++column) {
      const double x = (column + 0.5) * kPixel_m;
      const double y = (row + 0.5) * kPixel_m;
      const double ribbon = to_ribbon(axis, x - width / 2, y - height / 2);
      Rgb8& pixel = bitmap.pixels()(column, row);
      if (ribbon < kRibbonHalf_m) {
        pixel = ribbon > kRibbonHalf_m - 0.0025 ? kRibbonEdge : kRibbon;
      } else {
        pixel = paper_at(x, y, seed);
      }
    }
  }
  return bitmap;
}

}  // namespace

Texture wrapping_paper(const Eigen::Vector3d& size, std::uint64_t seed) {
  auto faces = std::make_shared<std::vector<Bitmap>>();
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const int across = axis == 0 ? 1 : 0;
    const int down = axis == 2 ? 1 : 2;
    faces->push_back(paint_face(axis, size[across], size[down], mix(seed + static_cast<std::uint64_t>(face))));
  }
  return [faces, half = Eigen::Vector3d(size / 2)](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    int axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    const int across = axis == 0 ? 1 : 0;
    const int down = axis == 2 ? 1 : 2;
    const auto face = static_cast<std::size_t>(2 * axis + (normal[axis] > 0 ? 1 : 0));
    // Bitmaps repeat beyond their border: stay half a pixel inside.
    const auto inside = [&](double value, int i) {
      return std::clamp(value + half[i], kPixel_m / 2, 2 * half[i] - kPixel_m / 2);
    };
    return (*faces)[face].at(inside(p[across], across), inside(-p[down], down));
  };
}

}  // namespace meshloop::simulation
