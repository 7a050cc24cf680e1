#pragma once
// A camera on a circle around the simulator's demo scene: pictures with known poses, and models of the scene.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/geometry/camera.h"
#include "common/image/frames.h"
#include "common/mesh/model.h"
#include "common/simulation/scene.h"
#include "common/simulation/sensor.h"
#include "device/track/model_tracker.h"

namespace meshloop::test {

inline Camera small_camera() {
  return {320, 240, 280, 280, 159.5, 119.5, {}};
}

/// T_camera_world at an angle of the circle.
inline Pose pose_at(double angle_deg, double radius_m = 1.15) {
  const double angle = angle_deg * std::numbers::pi / 180;
  const Eigen::Vector3d eye{radius_m * std::cos(angle), radius_m * std::sin(angle), 0.55 + 0.05 * std::sin(3 * angle)};
  return look_at(eye, {0.02 * std::sin(2 * angle), 0, 0.03}, Eigen::Vector3d::UnitZ()).inverse();
}

inline std::shared_ptr<const Model> model_of(const simulation::Scene& scene, bool modelled_only, double edge_m = 0.02) {
  auto model = std::make_shared<Model>();
  model->revision = 1;
  NodeId id = 1;
  for (auto& mesh : simulation::tessellate(scene, modelled_only, edge_m)) {
    model->nodes.push_back(make_node(id++, mesh.name, std::move(mesh.submesh)));
  }
  return model;
}

inline std::shared_ptr<const Model> without_colors(const Model& colored) {
  auto model = std::make_shared<Model>(colored);
  for (auto& node : model->nodes) {
    Submesh plain = *node.submesh;
    plain.colors.clear();
    node = make_node(node.id, node.name, std::move(plain), node.T_world_node);
  }
  return model;
}

inline ColorFrame frame_at(const simulation::Scene& scene, const Camera& camera, const Pose& T_camera_world,
                           int index) {
  ColorFrame frame;
  frame.index = index;
  frame.timestamp_s = index / 30.0;
  frame.color = simulation::cast_color(scene, camera, T_camera_world, 2);
  simulation::add_color_noise(frame.color, 2, static_cast<std::uint64_t>(index));
  return frame;
}

/// Distance between two camera centres.
inline double distance_m(const Pose& T_camera_world, const Pose& T_other_world) {
  return (T_camera_world.inverse().translation() - T_other_world.inverse().translation()).norm();
}

struct WalkResult {
  double mean_m = 0;
  double max_m = 0;
  int lost = 0;
  double lowest_quality = 1;
};

/// Tracks `frames` pictures along the circle, started at the true pose.
inline WalkResult walk(ModelTracker& tracker, const simulation::Scene& scene, const std::shared_ptr<const Model>& model,
                       const Camera& camera, int frames, double step_deg, double first_deg = 0) {
  WalkResult result;
  tracker.start_at(pose_at(first_deg));
  int known = 0;
  for (int i = 0; i < frames; ++i) {
    const Pose truth = pose_at(first_deg + i * step_deg);
    const TrackedPose tracked = tracker.track(frame_at(scene, camera, truth, i), model);
    if (tracked.state == TrackState::lost) {
      ++result.lost;
      continue;
    }
    ++known;
    const double error_m = distance_m(tracked.T_camera_world, truth);
    result.mean_m += error_m;
    result.max_m = std::max(result.max_m, error_m);
    result.lowest_quality = std::min(result.lowest_quality, tracked.quality);
  }
  result.mean_m /= std::max(1, known);
  return result;
}

}  // namespace meshloop::test
