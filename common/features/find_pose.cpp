#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "common/features/closed_form_pose.h"
#include "common/features/robust_pose.h"

namespace meshloop {
namespace {

constexpr int kMostSamples = 500;
constexpr double kConfidence = 0.999;

using Sample = std::array<std::size_t, 3>;

Sample draw(std::mt19937& random, std::size_t count) {
  Sample sample{};
  for (std::size_t k = 0; k < sample.size(); ++k) {
    const auto end = sample.begin() + static_cast<std::ptrdiff_t>(k);
    do {
      sample[k] = random() % count;
    } while (std::find(sample.begin(), end, sample[k]) != end);
  }
  return sample;
}

std::vector<Pose> poses_through(const std::vector<PointObservation>& points, const Sample& sample,
                                const Camera& camera) {
  std::array<Eigen::Vector3d, 3> p_world;
  std::array<Eigen::Vector2d, 3> pixels;
  for (std::size_t k = 0; k < sample.size(); ++k) {
    p_world[k] = points[sample[k]].p_world;
    pixels[k] = points[sample[k]].pixel;
  }
  return poses_from_three(p_world, pixels, camera);
}

struct Score {
  // Squared errors over the gate, capped at 1 a point (Torr, Zisserman 2000, MSAC).
  double cost = 0;
  int inliers = 0;
};

Score score(const std::vector<PointObservation>& points, const Camera& camera, const Pose& pose, double gate_px) {
  Score sum;
  for (const PointObservation& point : points) {
    const Eigen::Vector3d p = pose * point.p_world;
    double share = 1;
    if (p.z() > 1e-3) share = std::min(1.0, (camera.project(p) - point.pixel).squaredNorm() / (gate_px * gate_px));
    if (share < 1) ++sum.inliers;
    sum.cost += share;
  }
  return sum;
}

int samples_needed(int inliers, std::size_t count) {
  const double share = inliers / static_cast<double>(count);
  const double all_good = share * share * share;
  if (all_good > 0.999) return 1;
  if (all_good < 1e-6) return kMostSamples;
  return std::min(kMostSamples, static_cast<int>(std::log(1 - kConfidence) / std::log(1 - all_good)) + 1);
}

}  // namespace

std::optional<RobustPose> find_pose(const std::vector<PointObservation>& points, const Camera& camera,
                                    const RobustPoseOptions& options) {
  if (points.size() < 4 || static_cast<int>(points.size()) < options.min_inliers) return std::nullopt;
  const auto finite = [](const PointObservation& p) { return p.p_world.allFinite() && p.pixel.allFinite(); };
  if (!std::all_of(points.begin(), points.end(), finite)) return std::nullopt;
  std::mt19937 random{20150608};
  std::optional<Pose> best;
  Score best_score{static_cast<double>(points.size()), 0};
  int wanted = kMostSamples;
  for (int i = 0; i < wanted; ++i) {
    for (const Pose& pose : poses_through(points, draw(random, points.size()), camera)) {
      const Score current = score(points, camera, pose, options.max_error_px);
      if (current.cost >= best_score.cost) continue;
      best_score = current;
      best = pose;
      wanted = samples_needed(current.inliers, points.size());
    }
  }
  if (!best || best_score.inliers < 4) return std::nullopt;
  return refine_pose(points, camera, *best, options);
}

}  // namespace meshloop
