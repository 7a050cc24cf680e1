#pragma once
// A room with boxes and balls, and a sensor that looks at it: what the tests of the comparison share.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "server/compare/comparator.h"

namespace meshloop::compare_test {

inline Submesh quad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                    const Eigen::Vector3f& d) {
  Submesh submesh;
  submesh.positions = {a, b, c, d};
  submesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return submesh;
}

inline Submesh box(const Eigen::Vector3f& size) {
  Submesh submesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner((i & 1) != 0 ? 1.0F : -1.0F, (i & 2) != 0 ? 1.0F : -1.0F, (i & 4) != 0 ? 1.0F : -1.0F);
    submesh.positions.push_back(0.5F * size.cwiseProduct(corner));
  }
  submesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return submesh;
}

/// 2 * rings * rings triangles.
inline Submesh ball(float radius, int rings) {
  Submesh submesh;
  const auto count = static_cast<std::uint32_t>(rings);
  for (std::uint32_t i = 0; i <= count; ++i) {
    for (std::uint32_t j = 0; j <= count; ++j) {
      const float polar = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(count);
      const float around = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(count);
      submesh.positions.push_back(radius * Eigen::Vector3f(std::sin(polar) * std::cos(around),
                                                           std::sin(polar) * std::sin(around), std::cos(polar)));
      if (i == count || j == count) continue;
      const std::uint32_t here = i * (count + 1) + j;
      const std::uint32_t below = here + count + 1;
      submesh.triangles.push_back({here, below, here + 1});
      submesh.triangles.push_back({here + 1, below, below + 1});
    }
  }
  return submesh;
}

inline Pose at(double x, double y, double z, double turn = 0) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  pose.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d(0.3, 1, 0.2).normalized()).toRotationMatrix();
  return pose;
}

inline void add(Model& model, Submesh submesh, const Pose& T_world_node) {
  model.nodes.push_back(make_node(model.nodes.size() + 1, "node", std::move(submesh), T_world_node));
}

/// World as the camera of `room_pose` sees it: y down. Balls and boxes on a floor before a wall that ends in the
/// picture.
inline Model room_model(int rings = 24) {
  Model model;
  add(model, quad({-2, 0.6F, 0.2F}, {2, 0.6F, 0.2F}, {2, 0.6F, 3}, {-2, 0.6F, 3}), at(0, 0, 0));
  add(model, quad({-1, -1, 3}, {2, -1, 3}, {2, 0.6F, 3}, {-1, 0.6F, 3}), at(0, 0, 0));
  add(model, box({0.4F, 0.4F, 0.4F}), at(-0.4, 0.35, 1.5, 0.6));
  add(model, ball(0.25F, rings), at(0.4, 0.3, 1.8));
  add(model, box({0.3F, 0.1F, 0.2F}), at(0.1, 0.5, 1.2, 0.2));
  return model;
}

/// A box moved, a ball gone, a box and a ball new.
inline Model changed_model() {
  Model model = room_model();
  model.nodes[2].T_world_node = at(-0.38, 0.35, 1.47, 0.6);
  model.nodes.erase(model.nodes.begin() + 3);
  add(model, box({0.2F, 0.3F, 0.2F}), at(0.5, 0.3, 1.3, 0.4));
  add(model, ball(0.15F, 24), at(-0.7, -0.8, 2));
  return model;
}

inline Camera camera_of(int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 0.91 * width;
  camera.fy = 0.92 * width;
  camera.cx = 0.5 * width - 0.3;
  camera.cy = 0.5 * height + 0.7;
  return camera;
}

inline TrackedPose room_pose() {
  TrackedPose pose;
  pose.state = TrackState::tracking;
  pose.T_camera_world = at(0.05, 0.02, 0.1, 0.05);
  // Correlated, so that no block of the covariance can be mistaken for another.
  Twist direction;
  direction << 0.5, -1, 2, 1.5, -0.7, 1;
  pose.covariance = 1e-6 * (PoseCovariance::Identity() + direction * direction.transpose());
  return pose;
}

/// Gaussian noise across and along the optical axis, quantisation, and holes.
inline DepthImage measure(const DepthImage& exact, const SensorModel& sensor, unsigned seed) {
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const double lateral = sensor.sigma_lateral_px(0);
  DepthImage measured(exact.width(), exact.height());
  for (int v = 0; v < exact.height(); ++v) {
    for (int u = 0; u < exact.width(); ++u) {
      const int x = std::clamp(u + static_cast<int>(std::lround(lateral * normal(random))), 0, exact.width() - 1);
      const int y = std::clamp(v + static_cast<int>(std::lround(lateral * normal(random))), 0, exact.height() - 1);
      double z = static_cast<double>(exact(x, y));
      if (z <= 0 || uniform(random) < 0.02) continue;
      z += sensor.sigma_z_m(z, 0) * normal(random);
      const double step = sensor.quantisation_m(z);
      measured(u, v) = static_cast<float>(step > 0 ? step * std::round(z / step) : z);
    }
  }
  return measured;
}

inline DepthImage render_depth(const Model& model, const Camera& camera, const Pose& T_camera_world) {
  DepthImage depth;
  Image<std::uint32_t> nodes;
  render_on_cpu(model, camera, T_camera_world, depth, nodes);
  return depth;
}

}  // namespace meshloop::compare_test
