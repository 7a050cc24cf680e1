#include "common/simulation/texture.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/simulation/random.h"

namespace meshloop::simulation {
namespace {

struct FacePoint {
  double x = 0;
  double y = 0;
  int axis = 2;
};

// Coordinates on the faces of a box: x as long as possible along the solid's x axis, y downwards.
FacePoint on_face(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  if (axis == 0) return {p.y(), -p.z(), axis};
  if (axis == 1) return {p.x(), -p.z(), axis};
  return {p.x(), -p.y(), axis};
}

// Much faster than std::floor on a baseline x86-64, which has no instruction for it.
int floor_of(double x) {
  const int truncated = static_cast<int>(x);
  return truncated - (x < truncated ? 1 : 0);
}

int wrapped(int i, int size) {
  if (i >= 0 && i < size) return i;
  const int rest = i % size;
  return rest < 0 ? rest + size : rest;
}

}  // namespace

Bitmap::Bitmap(double width_m, double height_m, double pixel_m)
    : pixels_(std::max(1, static_cast<int>(std::lround(width_m / pixel_m))),
              std::max(1, static_cast<int>(std::lround(height_m / pixel_m)))),
      pixel_m_{pixel_m} {}

Rgb8 Bitmap::at(double x_m, double y_m) const {
  const double x = x_m / pixel_m_ - 0.5;
  const double y = y_m / pixel_m_ - 0.5;
  const int floor_x = floor_of(x);
  const int floor_y = floor_of(y);
  const int right_share = static_cast<int>((x - floor_x) * 256);
  const int lower_share = static_cast<int>((y - floor_y) * 256);
  const int x0 = wrapped(floor_x, pixels_.width());
  const int y0 = wrapped(floor_y, pixels_.height());
  const int x1 = x0 + 1 == pixels_.width() ? 0 : x0 + 1;
  const int y1 = y0 + 1 == pixels_.height() ? 0 : y0 + 1;
  const Rgb8& a = pixels_(x0, y0);
  const Rgb8& b = pixels_(x1, y0);
  const Rgb8& c = pixels_(x0, y1);
  const Rgb8& d = pixels_(x1, y1);
  const auto mixed = [&](int pa, int pb, int pc, int pd) {
    const int upper = pa * (256 - right_share) + pb * right_share;
    const int lower = pc * (256 - right_share) + pd * right_share;
    return static_cast<std::uint8_t>((upper * (256 - lower_share) + lower * lower_share + (1 << 15)) >> 16);
  };
  return {mixed(a.r, b.r, c.r, d.r), mixed(a.g, b.g, c.g, d.g), mixed(a.b, b.b, c.b, d.b)};
}

Rgb8 scaled(Rgb8 color, double factor) {
  const auto channel = [factor](std::uint8_t value) {
    return static_cast<std::uint8_t>(std::clamp(value * factor + 0.5, 0.0, 255.0));
  };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

Rgb8 blended(Rgb8 a, Rgb8 b, double share_of_b) {
  const double share = std::clamp(share_of_b, 0.0, 1.0);
  const auto channel = [share](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(from + (to - from) * share + 0.5);
  };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

double smooth_noise(double x, double y, std::uint64_t seed) {
  const int floor_x = floor_of(x);
  const int floor_y = floor_of(y);
  const auto value = [&](int dx, int dy) {
    const auto column = static_cast<std::uint64_t>(static_cast<std::uint32_t>(floor_x + dx));
    const auto row = static_cast<std::uint64_t>(static_cast<std::uint32_t>(floor_y + dy));
    return 2 * to_unit(mix(seed ^ (column << 32 | row))) - 1;
  };
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double s = ease(x - floor_x);
  const double t = ease(y - floor_y);
  const double upper = value(0, 0) + s * (value(1, 0) - value(0, 0));
  const double lower = value(0, 1) + s * (value(1, 1) - value(0, 1));
  return upper + t * (lower - upper);
}

Texture plain(Rgb8 color, const Eigen::Vector3d& size, std::uint64_t seed) {
  constexpr double kEdge_m = 0.003;
  return [color, half = Eigen::Vector3d(size / 2), seed](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    const FacePoint point = on_face(p, normal);
    double to_edge = 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(normal[axis]) < 0.5) to_edge = std::min(to_edge, half[axis] - std::abs(p[axis]));
    }
    const double edge = to_edge < kEdge_m ? 0.86 + 0.14 * to_edge / kEdge_m : 1.0;
    const double spots = smooth_noise(point.x / 0.03, point.y / 0.03, seed + static_cast<std::uint64_t>(point.axis));
    return scaled(color, edge * (1 + 0.02 * spots));
  };
}

Texture wood(Rgb8 light, Rgb8 dark, std::uint64_t seed) {
  auto bitmap = std::make_shared<Bitmap>(1.7, 0.7, 0.002);
  for (int row = 0; row < bitmap->pixels().height(); ++row) {
    for (int column = 0; column < bitmap->pixels().width(); ++column) {
      const double x = column * bitmap->pixel_m();
      const double y = row * bitmap->pixel_m();
      const double plank = std::floor(y / 0.14);
      const double bend = 0.012 * smooth_noise(x / 0.35, y / 0.10 + 17 * plank, seed);
      const double rings = std::sin(2 * 3.14159 * ((y + bend) / 0.022 + smooth_noise(x / 0.5, y / 0.05, seed + 1)));
      const double fibres = smooth_noise(x / 0.05, y / 0.003, seed + 2);
      const double tone = smooth_noise(plank * 3.7, 0.5, seed + 3);
      bitmap->pixels()(column, row) = blended(light, dark, 0.36 + 0.13 * rings + 0.16 * fibres + 0.14 * tone);
    }
  }
  return [bitmap](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) {
    const FacePoint point = on_face(p, normal);
    return bitmap->at(point.x + 0.85 + 0.31 * point.axis, point.y + 0.35 + 0.17 * (2 - point.axis));
  };
}

}  // namespace meshloop::simulation
