#include "server/compare/frame_average.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "server/compare/compare_input.h"
#include "server/compare/pixel_uncertainty.h"

namespace meshloop {
namespace {

// Where the motion of a camera is judged: its view's corners and middle, at this distance.
constexpr double kJudged_m = 2;
constexpr double kMostShift_px = 0.5;
// Of the sensor's sigma.
constexpr double kMostAxialShift = 0.25;
constexpr double kSigmas = 3;

std::array<Eigen::Vector3d, 5> judged_points(const Camera& camera) {
  const double right = camera.width - 1;
  const double bottom = camera.height - 1;
  return {camera.back_project(0, 0, kJudged_m), camera.back_project(right, 0, kJudged_m),
          camera.back_project(0, bottom, kJudged_m), camera.back_project(right, bottom, kJudged_m),
          camera.back_project(right / 2, bottom / 2, kJudged_m)};
}

struct Mean {
  float depth_m = 0;
  std::uint8_t frames = 0;
};

// `values` are depths in any order, and are put in order.
Mean mean_of(std::span<float> values, int frames, const SensorModel& sensor) {
  if (2 * static_cast<int>(values.size()) < frames || values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto median = static_cast<double>(values[values.size() / 2]);
  const double gate = kSigmas * sensor.sigma_z_m(median, 0) + sensor.quantisation_m(median);
  double sum = 0;
  int count = 0;
  for (const float value : values) {
    if (std::abs(static_cast<double>(value) - median) > gate) continue;
    sum += static_cast<double>(value);
    ++count;
  }
  if (2 * count < frames) return {};
  return {static_cast<float>(sum / count), static_cast<std::uint8_t>(count)};
}

}  // namespace

Status FrameAverage::check_rest(const TrackedPose& pose) const {
  const Pose motion = pose.T_camera_world * pose_->T_camera_world.inverse();
  const PoseCovariance covariance = pose.covariance + pose_->covariance;
  const double most_axial_m = kMostAxialShift * sensor_.sigma_z_m(kJudged_m, 0);
  for (const Eigen::Vector3d& p : judged_points(camera_)) {
    const Eigen::Vector3d moved = motion * p;
    const double shift_px = moved.z() > 0 ? (camera_.project(moved) - camera_.project(p)).norm() : 1e9;
    const double axial_m = std::abs(moved.z() - p.z());
    const Eigen::Matrix2d pixel = pixel_by_twist(camera_, p) * covariance * pixel_by_twist(camera_, p).transpose();
    const double axial_variance = depth_by_twist(Eigen::Vector3d::UnitZ() / p.z(), p) * covariance *
                                  depth_by_twist(Eigen::Vector3d::UnitZ() / p.z(), p).transpose();
    if (shift_px > kMostShift_px + kSigmas * std::sqrt(std::max(0.0, pixel.trace())) ||
        axial_m > most_axial_m + kSigmas * std::sqrt(std::max(0.0, axial_variance))) {
      return fail(
          fmt::format("the camera moved since the first frame of the average, by {:.1f} pixels and {:.1f} mm at {} m; "
                      "choose frames in which it rests",
                      shift_px, 1e3 * axial_m, kJudged_m));
    }
  }
  return {};
}

Status FrameAverage::add(const DepthImage& measured, const TrackedPose& pose) {
  if (measured.width() != camera_.width || measured.height() != camera_.height) {
    return fail(fmt::format("the depth image has {}x{} pixels, but its camera {}x{}", measured.width(),
                            measured.height(), camera_.width, camera_.height));
  }
  if (pose.state == TrackState::lost) return fail("the pose of this frame is lost; average frames that are tracked");
  if (count() == kMostFrames) return fail(fmt::format("an average takes at most {} frames", kMostFrames));
  if (pose_) {
    if (auto rests = check_rest(pose); !rests) return rests;
  } else {
    pose_ = pose;
  }
  frames_.push_back(measured);
  return {};
}

AveragedDepth FrameAverage::result() const {
  AveragedDepth result{DepthImage(camera_.width, camera_.height), Image<std::uint8_t>(camera_.width, camera_.height),
                       count()};
  std::array<float, kMostFrames> values{};
  for (std::size_t i = 0; i < result.mean.size(); ++i) {
    std::size_t measured = 0;
    for (const DepthImage& frame : frames_) {
      const float z = usable_depth(frame.data()[i]);
      if (z > 0) values[measured++] = z;
    }
    const Mean mean = mean_of({values.data(), measured}, count(), sensor_);
    result.mean.data()[i] = mean.depth_m;
    result.frames.data()[i] = mean.frames;
  }
  return result;
}

void FrameAverage::reset() {
  pose_.reset();
  frames_.clear();
}

}  // namespace meshloop
