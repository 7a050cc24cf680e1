#pragma once
// A wall with a picture thrown onto it from aside: what is drawn, sent, stored or exported of it can be told pixel by
// pixel.
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/image/jpeg_codec.h"
#include "common/mesh/lattice.h"
#include "common/mesh/submesh.h"

namespace meshloop::test {

/// Smooth in both directions, so that a fraction of a pixel's error is a level or more of 255 and no more.
inline ColorImage smooth_picture(int width, int height) {
  ColorImage picture{width, height};
  const auto level = [](double phase) { return static_cast<std::uint8_t>(std::lround(128 + 90 * std::sin(phase))); };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) picture(x, y) = {level(0.11 * x), level(0.09 * y), level(0.05 * (x + y))};
  }
  return picture;
}

inline std::shared_ptr<const ProjectedTexture> must_project(const ColorImage& picture,
                                                            const TextureProjection& projection, int quality = 95) {
  auto jpeg = encode_jpeg(picture, quality);
  if (!jpeg) throw std::runtime_error(jpeg.error().message);
  auto texture = make_projected_texture(std::move(*jpeg), projection);
  if (!texture) throw std::runtime_error(texture.error().message);
  return *texture;
}

/// The projection of a camera in a place.
inline TextureProjection projection_of(const Camera& camera, const Pose& T_camera_node) {
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return (K * T_camera_node.matrix().topRows<3>()).cast<float>();
}

inline Camera projector_camera() {
  return {160, 120, 125, 125, 79.5, 59.5, {}};
}

/// From aside of the wall and before it, so that the picture is thrown aslant.
inline Pose projector_pose() {
  return look_at({-0.9, -0.3, 0.2}, {0, 0, 1.5}, {0, -1, 0}).inverse();
}

/// Two triangles of 1.5 x 1 m, 1.5 m before the origin along z, on the lattice. All of it lies in the picture.
inline Submesh textured_wall() {
  Submesh wall;
  wall.positions = {{-0.75F, -0.5F, 1.5F}, {0.75F, -0.5F, 1.5F}, {0.75F, 0.5F, 1.5F}, {-0.75F, 0.5F, 1.5F}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Camera camera = projector_camera();
  wall.texture = must_project(smooth_picture(camera.width, camera.height), projection_of(camera, projector_pose()));
  return wall;
}

}  // namespace meshloop::test
