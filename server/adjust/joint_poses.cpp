#include "server/adjust/joint_poses.h"

#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/base/median.h"
#include "server/adjust/expected_planes.h"
#include "server/adjust/flat_blocks.h"
#include "server/adjust/pose_factors.h"

namespace meshloop {
namespace {

using adjust::ExpectedPlanes;
using adjust::FlatBlocks;
using adjust::HeldDirections;
using adjust::MatchFactor;
using adjust::MatchSums;
using adjust::PlaneMatch;
using adjust::PoseBlock;

/// The loss is wide at first, so that a wrong pose is found back.
constexpr std::array<double, 4> kCuts_m{0.04, 0.015, 0, 0};
constexpr int kSteps = 4;
/// Between two frames, and between a frame and the model.
constexpr std::size_t kMostBetween = 400;
constexpr std::size_t kMostOnModel = 1200;
/// Fewer hold nothing.
constexpr std::size_t kFewest = 30;
/// Cosine between the normals of what is one surface.
constexpr double kAlike = 0.94;  // 20 degrees
constexpr double kLargest_sigmas = 5;
/// The distances must become less by this share.
constexpr double kBetter = 0.002;

/// What two frames, or a frame and the model, say of each other.
struct Pair {
  std::size_t of = 0;
  /// Another frame; none: the model, as frame `planes` expects it.
  std::optional<std::size_t> to;
  std::size_t planes = 0;
  std::vector<PlaneMatch> matches;
};

class Joint {
 public:
  Joint(std::span<const PosedDepth> frames, const Camera& camera, const SensorModel& sensor) : frames_{frames} {
    for (const auto& frame : frames) {
      blocks_.emplace_back(*frame.depth, camera, sensor);
      if (frame.comparison != nullptr) pictures_.emplace_back(*frame.comparison, camera, sensor);
      model_of_.push_back(pictures_.empty() ? std::nullopt : std::optional{pictures_.size() - 1});
      if (frame.comparison != nullptr) T_picture_world_.push_back(frame.T_camera_world);
      information_.push_back(information_of(frame.covariance));
    }
    depth_m_ = typical_depth_m();
  }

  [[nodiscard]] bool all_exact() const {
    return std::none_of(information_.begin(), information_.end(), [](const auto& known) { return known.has_value(); });
  }

  [[nodiscard]] std::vector<Pair> pairs(const std::vector<Pose>& poses) {
    std::vector<Pair> found;
    const auto keep = [&found](Pair pair) {
      if (pair.matches.size() >= kFewest) found.push_back(std::move(pair));
    };
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (model_of_[i]) keep(with_model(i, *model_of_[i], poses[i]));
      for (std::size_t j = 0; j < i; ++j) keep(between(i, j, poses[i], poses[j]));
    }
    return found;
  }

  [[nodiscard]] MatchSums sums_of(const Pair& pair, const std::vector<Pose>& poses, double cut_m) const {
    return sum_matches(pair.matches, relative(pair, poses), cut_m);
  }
  [[nodiscard]] HeldDirections held_by(const MatchSums& sums) const { return adjust::held_by(sums, depth_m_); }

  /// The poses that fit these pairs best.
  [[nodiscard]] std::vector<Pose> solve(const std::vector<Pair>& pairs, const std::vector<Pose>& start,
                                        double cut_m) const {
    std::vector<PoseBlock> blocks;
    for (const auto& pose : start) blocks.push_back(adjust::to_block(pose));
    ceres::Problem problem;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      problem.AddParameterBlock(blocks[i].data(), 7, new adjust::PoseManifold);
      if (!information_[i]) {
        problem.SetParameterBlockConstant(blocks[i].data());
        continue;
      }
      problem.AddResidualBlock(new adjust::PosePrior{frames_[i].T_camera_world, *information_[i]}, nullptr,
                               blocks[i].data());
    }
    for (const auto& pair : pairs) {
      const HeldDirections held = held_by(sums_of(pair, start, cut_m));
      double* of = blocks[pair.of].data();
      if (pair.to) {
        problem.AddResidualBlock(new MatchFactor{pair.matches, cut_m, held}, nullptr, of, blocks[*pair.to].data());
      } else {
        problem.AddResidualBlock(new MatchFactor{pair.matches, T_picture_world_[pair.planes], cut_m, held}, nullptr,
                                 of);
      }
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = kSteps;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable()) return start;
    std::vector<Pose> poses;
    for (const auto& block : blocks) poses.push_back(adjust::to_pose(block.data()));
    return poses;
  }

  /// The correction of a frame's pose, in its own sigma; 0 of an exact one.
  [[nodiscard]] double sigmas_of(std::size_t frame, const Pose& T_camera_world) const {
    if (!information_[frame]) return 0;
    const Twist correction = log(T_camera_world * frames_[frame].T_camera_world.inverse());
    return std::sqrt(correction.dot(*information_[frame] * correction));
  }

 private:
  static std::optional<PoseCovariance> information_of(const PoseCovariance& covariance) {
    const Eigen::LLT<PoseCovariance> root{covariance};
    if (root.info() != Eigen::Success) return std::nullopt;
    return root.solve(PoseCovariance::Identity());
  }

  [[nodiscard]] double typical_depth_m() const {
    std::vector<double> depths;
    for (const auto& block : blocks_.front().all()) depths.push_back(block.point.z());
    if (depths.empty()) return 1;
    return median(std::move(depths));
  }

  [[nodiscard]] Pose relative(const Pair& pair, const std::vector<Pose>& poses) const {
    return (pair.to ? poses[*pair.to] : T_picture_world_[pair.planes]) * poses[pair.of].inverse();
  }

  [[nodiscard]] Pair with_model(std::size_t i, std::size_t picture, const Pose& pose) {
    Pair pair{i, std::nullopt, picture, {}};
    const Pose T_picture_camera = T_picture_world_[picture] * pose.inverse();
    const auto& blocks = blocks_[i].all();
    const std::size_t every = blocks.size() / kMostOnModel + 1;
    for (std::size_t k = i % every; k < blocks.size(); k += every) {
      const auto* plane = pictures_[picture].at(T_picture_camera * blocks[k].point);
      if (plane == nullptr) continue;
      // A plane of the expected depth faces either way.
      const double alike = plane->normal().dot(T_picture_camera.linear() * blocks[k].normal);
      if (std::abs(alike) < kAlike) continue;
      pair.matches.push_back({blocks[k].point, *plane, blocks[k].sigma_m, 0});
    }
    return pair;
  }

  [[nodiscard]] Pair between(std::size_t i, std::size_t j, const Pose& pose_i, const Pose& pose_j) const {
    Pair pair{i, j, 0, {}};
    const Pose T_j_i = pose_j * pose_i.inverse();
    const auto& blocks = blocks_[i].all();
    const std::size_t every = blocks.size() / kMostBetween + 1;
    for (std::size_t k = (i + 3 * j) % every; k < blocks.size(); k += every) {
      const auto* other = blocks_[j].at(T_j_i * blocks[k].point);
      if (other == nullptr || other->normal.dot(T_j_i.linear() * blocks[k].normal) < kAlike) continue;
      // Towards the edge of a block its plane is twice as uncertain as in the middle.
      const double sigma_m = std::hypot(blocks[k].sigma_m, std::numbers::sqrt2 * other->sigma_m);
      pair.matches.push_back({blocks[k].point, Eigen::Hyperplane<double, 3>{other->normal, other->point}, sigma_m,
                              other->normal_variance});
    }
    return pair;
  }

  std::span<const PosedDepth> frames_;
  std::vector<FlatBlocks> blocks_;
  std::vector<ExpectedPlanes> pictures_;
  std::vector<Pose> T_picture_world_;
  std::vector<std::optional<std::size_t>> model_of_;
  std::vector<std::optional<PoseCovariance>> information_;
  double depth_m_ = 1;
};

/// How all pairs stand.
struct Standing {
  JointPoses::Distances distances;
  int on_model = 0;
  int between_frames = 0;
  int held_by_model = 0;
  int held_by_frames = 0;
  /// For each match, from 0 to 1.
  double loss = 0;
};

Standing standing(Joint& joint, const std::vector<Pose>& poses) {
  Standing result;
  result.held_by_frames = 6;
  MatchSums on_model;
  MatchSums between;
  std::size_t matches = 0;
  bool any_to_first = false;
  for (const auto& pair : joint.pairs(poses)) {
    const MatchSums sums = joint.sums_of(pair, poses, 0);
    MatchSums& all = pair.to ? between : on_model;
    all.weighted_squares += sums.weighted_squares;
    all.weight += sums.weight;
    all.agreeing += sums.agreeing;
    result.loss += sums.cost;
    matches += pair.matches.size();
    const int held = joint.held_by(sums).count;
    if (!pair.to && pair.of == 0) result.held_by_model = held;
    if (!pair.to || *pair.to != 0) continue;
    any_to_first = true;
    result.held_by_frames = std::min(result.held_by_frames, held);
  }
  if (!any_to_first) result.held_by_frames = 0;
  const auto rms = [](const MatchSums& sums) {
    return sums.weight > 0 ? std::sqrt(sums.weighted_squares / sums.weight) : 0;
  };
  result.distances = {rms(on_model), rms(between)};
  result.on_model = on_model.agreeing;
  result.between_frames = between.agreeing;
  result.loss = matches > 0 ? result.loss / static_cast<double>(matches) : 1;
  return result;
}

std::optional<std::string> reason_to_refuse(const Joint& joint, const Standing& before, const Standing& after,
                                            const std::vector<Pose>& poses) {
  if (after.on_model + after.between_frames == 0) return "the frames show nothing flat in common";
  if (after.loss > (1 - kBetter) * before.loss)
    return "it brings the frames nearer neither to each other nor to the model";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double sigmas = joint.sigmas_of(i, poses[i]);
    if (!(sigmas <= kLargest_sigmas)) {
      return fmt::format("the correction of frame {} of {} is {:.0f} sigma of its pose", i + 1, poses.size(), sigmas);
    }
  }
  return std::nullopt;
}

}  // namespace

JointPoses refine_poses(std::span<const PosedDepth> frames, const Camera& camera, const SensorModel& sensor) {
  JointPoses result;
  for (const auto& frame : frames) result.T_camera_world.push_back(frame.T_camera_world);
  std::vector<Pose> start{result.T_camera_world};
  start.resize(std::min(start.size(), kMostJointFrames));
  Joint joint{frames.first(start.size()), camera, sensor};
  if (joint.all_exact()) {
    result.refused = "the poses count as exact";
    return result;
  }
  std::vector<Pose> poses = start;
  for (const double cut_m : kCuts_m) poses = joint.solve(joint.pairs(poses), poses, cut_m);
  const Standing before = standing(joint, start);
  const Standing after = standing(joint, poses);
  result.before = before.distances;
  result.after = after.distances;
  result.on_model = after.on_model;
  result.between_frames = after.between_frames;
  result.held_by_model = after.held_by_model;
  result.held_by_frames = after.held_by_frames;
  result.refused = reason_to_refuse(joint, before, after, poses);
  if (!result.refused) std::copy(poses.begin(), poses.end(), result.T_camera_world.begin());
  return result;
}

}  // namespace meshloop
