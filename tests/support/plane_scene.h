#pragma once
// Textured rectangles seen by a pinhole camera: the exact pose and depth of every pixel is known. For tests of
// tracking.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/image/image.h"

namespace meshloop::test {

/// Spans (0, 0) to (width_m, height_m) in its own x-y plane; row 0 of the texture lies at y = 0. Seen from its front, x
/// points right, y down and z away from the viewer.
struct TexturedPlane {
  Pose T_world_plane = Pose::Identity();
  double width_m = 1;
  double height_m = 1;
  GreyImage texture;
  /// Bilinear between the middles of texels; false: square texels with hard edges.
  bool smooth = true;
};

struct PlaneView {
  GreyImage image;
  /// Along the optical axis; 0 where there is no plane.
  DepthImage depth;
};

/// Blotches of random grey with all frequencies up to the texel's.
inline GreyImage blotches(int width, int height, unsigned seed) {
  std::mt19937 random{seed};
  GreyImage texture{width, height};
  for (std::uint8_t& texel : texture.pixels()) texel = static_cast<std::uint8_t>(30 + random() % 196);
  return texture;
}

namespace detail {

// Plain numbers: this runs for every ray, also in tests that are built without optimisation.
struct PreparedPlane {
  const TexturedPlane* plane;
  // For the ray (x, y, 1): plane coordinates are (h ray)_01 / (h ray)_2, and its depth is distance / (normal ray).
  std::array<double, 9> h;
  std::array<double, 3> normal;
  double distance;
  // Pixels that it may cover.
  int left, top, right, bottom;
};

inline PreparedPlane prepare(const TexturedPlane& plane, const Camera& camera, const Pose& T_camera_world) {
  const Pose T_camera_plane = T_camera_world * plane.T_world_plane;
  Eigen::Matrix3d to_camera;
  to_camera << T_camera_plane.linear().col(0), T_camera_plane.linear().col(1), T_camera_plane.translation();
  const Eigen::Matrix3d h = to_camera.inverse();
  const Eigen::Vector3d n = T_camera_plane.linear().col(2);
  PreparedPlane prepared{&plane,
                         {h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0), h(2, 1), h(2, 2)},
                         {n.x(), n.y(), n.z()},
                         n.dot(T_camera_plane.translation()),
                         0,
                         0,
                         camera.width - 1,
                         camera.height - 1};
  Eigen::AlignedBox2d seen;
  for (const double x : {0.0, plane.width_m}) {
    for (const double y : {0.0, plane.height_m}) {
      const Eigen::Vector3d p = T_camera_plane * Eigen::Vector3d{x, y, 0};
      // Partly behind the camera: it may cover everything.
      if (p.z() < 0.01) return prepared;
      seen.extend(camera.project(p));
    }
  }
  prepared.left = static_cast<int>(std::clamp(seen.min().x() - 1, 0.0, camera.width - 1.0));
  prepared.top = static_cast<int>(std::clamp(seen.min().y() - 1, 0.0, camera.height - 1.0));
  prepared.right = static_cast<int>(std::clamp(seen.max().x() + 2, -1.0, camera.width - 1.0));
  prepared.bottom = static_cast<int>(std::clamp(seen.max().y() + 2, -1.0, camera.height - 1.0));
  return prepared;
}

inline double texel(const TexturedPlane& plane, double x, double y) {
  const double u = x / plane.width_m * plane.texture.width();
  const double v = y / plane.height_m * plane.texture.height();
  const auto at = [&plane](int i, int j) {
    return static_cast<double>(
        plane.texture(std::clamp(i, 0, plane.texture.width() - 1), std::clamp(j, 0, plane.texture.height() - 1)));
  };
  if (!plane.smooth) return at(static_cast<int>(u), static_cast<int>(v));
  const int i = static_cast<int>(std::floor(u - 0.5));
  const int j = static_cast<int>(std::floor(v - 0.5));
  const double s = u - 0.5 - i;
  const double t = v - 0.5 - j;
  return (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) + t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1));
}

// The grey where the ray (x, y, 1) ends, and its depth there (0: nowhere).
inline double cast(const std::vector<const PreparedPlane*>& planes, double ray_x, double ray_y, double background,
                   double& z) {
  double grey = background;
  z = 0;
  for (const PreparedPlane* p : planes) {
    const double w = p->h[6] * ray_x + p->h[7] * ray_y + p->h[8];
    const double x = (p->h[0] * ray_x + p->h[1] * ray_y + p->h[2]) / w;
    const double y = (p->h[3] * ray_x + p->h[4] * ray_y + p->h[5]) / w;
    if (!(w > 0 && x >= 0 && y >= 0 && x < p->plane->width_m && y < p->plane->height_m)) continue;
    const double depth = p->distance / (p->normal[0] * ray_x + p->normal[1] * ray_y + p->normal[2]);
    if (z > 0 && depth >= z) continue;
    z = depth;
    grey = texel(*p->plane, x, y);
  }
  return grey;
}

}  // namespace detail

/// Each pixel is the mean of samples x samples rays over its area.
inline PlaneView render_planes(const std::vector<TexturedPlane>& planes, const Camera& camera,
                               const Pose& T_camera_world, int samples = 4, std::uint8_t background = 128) {
  PlaneView view{{camera.width, camera.height, background}, {camera.width, camera.height}};
  std::vector<detail::PreparedPlane> prepared;
  for (const TexturedPlane& plane : planes) prepared.push_back(detail::prepare(plane, camera, T_camera_world));
  std::vector<const detail::PreparedPlane*> here;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      here.clear();
      for (const detail::PreparedPlane& p : prepared) {
        if (x >= p.left && x <= p.right && y >= p.top && y <= p.bottom) here.push_back(&p);
      }
      if (here.empty()) continue;
      double sum = 0;
      double z = 0;
      for (int k = 0; k < samples * samples; ++k) {
        const double u = x - 0.5 + (k % samples + 0.5) / samples;
        const double v = y - 0.5 + (k / samples + 0.5) / samples;
        sum += detail::cast(here, (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, background, z);
      }
      view.image(x, y) = static_cast<std::uint8_t>(std::lround(sum / (samples * samples)));
      detail::cast(here, (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, background, z);
      view.depth(x, y) = static_cast<float>(z);
    }
  }
  return view;
}

inline void add_noise(GreyImage& image, double sigma, unsigned seed) {
  std::mt19937 random{seed};
  std::normal_distribution<double> noise{0, sigma};
  for (std::uint8_t& pixel : image.pixels()) {
    pixel = static_cast<std::uint8_t>(std::clamp(std::lround(pixel + noise(random)), 0L, 255L));
  }
}

/// A marker's cells with one more white cell around them.
inline TexturedPlane marker_plane(const GreyImage& pattern, const Pose& T_world_marker, double side_m) {
  TexturedPlane plane;
  const double cell = side_m / pattern.width();
  plane.texture = GreyImage{pattern.width() + 2, pattern.height() + 2, 255};
  for (int y = 0; y < pattern.height(); ++y) {
    for (int x = 0; x < pattern.width(); ++x) plane.texture(x + 1, y + 1) = pattern(x, y);
  }
  plane.T_world_plane = T_world_marker * Eigen::Translation3d{-cell, -cell, 0};
  plane.width_m = plane.height_m = cell * plane.texture.width();
  plane.smooth = false;
  return plane;
}

/// Corners of that marker in the world, clockwise from the upper left; T_world_marker is at the upper left corner.
inline std::array<Eigen::Vector3d, 4> marker_corners(const Pose& T_world_marker, double side_m) {
  return {T_world_marker * Eigen::Vector3d{0, 0, 0}, T_world_marker * Eigen::Vector3d{side_m, 0, 0},
          T_world_marker * Eigen::Vector3d{side_m, side_m, 0}, T_world_marker * Eigen::Vector3d{0, side_m, 0}};
}

inline Camera vga_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 525;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

}  // namespace meshloop::test
