#include "server/adjust/joint_poses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "boxes.h"
#include "server/adjust/depth_fusion.h"
#include "server/adjust/pose_factors.h"
#include "server/adjust/registration.h"

namespace meshloop {
namespace {

using boxes::Box;

const SensorModel kKinect{SensorModel::Kind::kinect1};
const Camera kCamera{320, 240, 290, 290, 159.5, 119.5, {}};

/// A corner of a room; the model has all of it, or only the floor, while shelves and boxes are new.
std::vector<Box> room(bool is_modelled) {
  const NodeId known = is_modelled ? 2 : 0;
  return {{{-2, 0.6, -1}, {2, 0.7, 3}, 1},
          {{-2, -2, 2.2}, {2, 2, 2.3}, known},
          {{-1.3, -2, -1}, {-1.2, 2, 3}, known},
          {{0.2, 0.2, 1.2}, {0.6, 0.6, 1.5}, known},
          {{-0.7, 0.3, 1.5}, {-0.3, 0.6, 1.8}, known},
          {{-0.3, -0.4, 1.0}, {0.25, 0.2, 1.1}, 0}};
}

/// A hand that holds still as well as it can, and a tracker.
struct Frames {
  std::vector<Box> boxes;
  std::vector<Pose> T_camera_world;
  std::vector<DepthImage> depths;
  Comparison comparison;
  std::vector<PosedDepth> tracked;

  Frames(std::vector<Box> scene, int count, double sigma_m, double sigma_rad, unsigned seed) : boxes{std::move(scene)} {
    std::mt19937 random{seed};
    std::normal_distribution<double> any;
    depths.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      const auto wobble = [&] { return Eigen::Vector3d{any(random), any(random), any(random)}; };
      const Eigen::Vector3d eye = Eigen::Vector3d{0.3, -0.5, -0.2} + 0.01 * wobble();
      T_camera_world.push_back(look_at(eye, Eigen::Vector3d{-0.2, 0.3, 1.6} + 0.01 * wobble(), {0, -1, 0}).inverse());
      depths.push_back(
          boxes::measure(boxes, kCamera, T_camera_world.back(), kKinect, 1000 * seed + static_cast<unsigned>(i)));
      PosedDepth frame;
      frame.depth = &depths.back();
      Twist error;
      error << sigma_m * wobble(), sigma_rad * wobble();
      frame.T_camera_world = exp(error) * T_camera_world.back();
      frame.covariance.diagonal() << Eigen::Vector3d::Constant(sigma_m * sigma_m),
          Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
      tracked.push_back(frame);
    }
    comparison = expected_from(tracked[0].T_camera_world);
    tracked[0].comparison = &comparison;
  }
  Frames(const Frames&) = delete;
  Frames& operator=(const Frames&) = delete;

  [[nodiscard]] Comparison expected_from(const Pose& pose) const {
    std::vector<Box> modelled;
    for (const auto& box : boxes) {
      if (box.node != 0) modelled.push_back(box);
    }
    auto seen = boxes::cast(modelled, kCamera, pose);
    Comparison result;
    result.expected = std::move(seen.depth);
    result.node_index = std::move(seen.box);
    return result;
  }

  [[nodiscard]] std::vector<Pose> own() const {
    std::vector<Pose> poses;
    for (const auto& frame : tracked) poses.push_back(frame.T_camera_world);
    return poses;
  }

  /// Each frame by itself, to the model.
  [[nodiscard]] std::vector<Pose> registered() const {
    std::vector<Pose> poses;
    Rig rig;
    rig.depth = kCamera;
    rig.sensor = kKinect;
    for (const auto& view : tracked) {
      const Comparison expected = expected_from(view.T_camera_world);
      RgbdFrame frame;
      frame.depth = *view.depth;
      Snapshot snapshot;
      snapshot.frame = &frame;
      snapshot.rig = &rig;
      snapshot.comparison = &expected;
      snapshot.depth_pose.state = TrackState::tracking;
      snapshot.depth_pose.T_camera_world = view.T_camera_world;
      snapshot.depth_pose.covariance = view.covariance;
      poses.push_back(refine_pose(snapshot).T_camera_world);
    }
    return poses;
  }
};

struct Error {
  /// Root mean square over frames: of the other frames' poses relative to the first, at a point 1.5 m away.
  double relative_m = 0;
  /// Of the fused surface from the true one, where the first frame's pose puts it.
  double surface_m = 0;
};

Error error_of(const Frames& frames, const std::vector<Pose>& poses) {
  Error error;
  const Eigen::Vector3d ahead{0, 0, 1.5};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose found = poses[i] * poses[0].inverse();
    const Pose truth = frames.T_camera_world[i] * frames.T_camera_world[0].inverse();
    error.relative_m += (found * ahead - truth * ahead).squaredNorm();
  }
  error.relative_m = std::sqrt(error.relative_m / static_cast<double>(poses.size() - 1));
  std::vector<DepthView> views;
  for (std::size_t i = 0; i < poses.size(); ++i) views.push_back({frames.tracked[i].depth, poses[i]});
  const DepthImage fused = fuse_depth(views, kCamera, kKinect, {}).depth;
  const DepthImage truth = boxes::cast(frames.boxes, kCamera, poses[0]).depth;
  int count = 0;
  for (std::size_t k = 0; k < fused.size(); ++k) {
    const auto z = static_cast<double>(fused.pixels()[k]);
    const double off = z - static_cast<double>(truth.pixels()[k]);
    if (!(z > 0) || std::abs(off) > 0.05) continue;  // beside an outline another surface is the true one
    error.surface_m += off * off;
    ++count;
  }
  error.surface_m = std::sqrt(error.surface_m / count);
  return error;
}

struct Comparisons {
  Error tracked, registered, joint;
  int refused = 0;
  int worse = 0;
};

Comparisons compare(const std::vector<Box>& scene, double sigma_m, double sigma_rad, unsigned seeds) {
  Comparisons sum;
  const auto add = [](Error& to, const Error& error) {
    to.relative_m += error.relative_m * error.relative_m;
    to.surface_m += error.surface_m * error.surface_m;
  };
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const Frames frames{scene, 8, sigma_m, sigma_rad, seed};
    const auto joint = refine_poses(frames.tracked, kCamera, kKinect);
    sum.refused += joint.refused ? 1 : 0;
    const Error before = error_of(frames, frames.own());
    const Error after = error_of(frames, joint.T_camera_world);
    sum.worse += after.surface_m > before.surface_m + 0.0003 ? 1 : 0;
    add(sum.tracked, before);
    add(sum.registered, error_of(frames, frames.registered()));
    add(sum.joint, after);
  }
  for (Error* error : {&sum.tracked, &sum.registered, &sum.joint}) {
    error->relative_m = std::sqrt(error->relative_m / seeds);
    error->surface_m = std::sqrt(error->surface_m / seeds);
  }
  const auto tell = [](const char* name, const Error& error) {
    std::printf("%-10s relative %.2f mm, surface %.2f mm\n", name, 1000 * error.relative_m, 1000 * error.surface_m);
  };
  tell("tracked", sum.tracked);
  tell("registered", sum.registered);
  tell("joint", sum.joint);
  std::printf("refused %d, worse %d of %u\n", sum.refused, sum.worse, seeds);
  return sum;
}

/// The gradient of a cost along steps of its manifold, against differences.
void expect_gradient(const ceres::CostFunction& cost, std::vector<adjust::PoseBlock> blocks) {
  const int rows = cost.num_residuals();
  std::vector<double*> parameters;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 7, Eigen::RowMajor>> jacobians;
  for (auto& block : blocks) {
    parameters.push_back(block.data());
    jacobians.emplace_back(rows, 7);
  }
  std::vector<double*> jacobian_data;
  for (auto& jacobian : jacobians) jacobian_data.push_back(jacobian.data());
  Eigen::VectorXd residuals{rows};
  const auto half_squares = [&] {
    cost.Evaluate(parameters.data(), residuals.data(), nullptr);
    return residuals.squaredNorm() / 2;
  };
  ASSERT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), jacobian_data.data()));
  const Eigen::VectorXd there = residuals;
  const adjust::PoseManifold manifold;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    ASSERT_TRUE(manifold.PlusJacobian(blocks[b].data(), plus.data()));
    const Twist gradient = (jacobians[b] * plus).transpose() * there;
    const auto start = blocks[b];
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-6;
      const auto at = [&](double step) {
        const Twist delta = step * Twist::Unit(i);
        manifold.Plus(start.data(), delta.data(), blocks[b].data());
        return half_squares();
      };
      const double difference = (at(kStep) - at(-kStep)) / (2 * kStep);
      blocks[b] = start;
      EXPECT_NEAR(gradient[i], difference, 1e-4 * (1 + gradient.norm())) << "block " << b << ", direction " << i;
    }
  }
}

Pose any_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> any{-1, 1};
  Twist twist;
  for (double& value : twist) value = any(random);
  return exp(twist);
}

TEST(PoseManifold, StepsAndDifferencesAreEachOthersInverse) {
  std::mt19937 random{5};
  const adjust::PoseManifold manifold;
  for (int i = 0; i < 20; ++i) {
    const auto x = adjust::to_block(any_pose(random));
    const auto y = adjust::to_block(any_pose(random));
    Twist step;
    adjust::PoseBlock back{};
    ASSERT_TRUE(manifold.Minus(y.data(), x.data(), step.data()));
    ASSERT_TRUE(manifold.Plus(x.data(), step.data(), back.data()));
    EXPECT_TRUE(adjust::to_pose(back.data()).isApprox(adjust::to_pose(y.data()), 1e-9));
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
    ASSERT_TRUE(manifold.PlusJacobian(x.data(), plus.data()));
    ASSERT_TRUE(manifold.MinusJacobian(x.data(), minus.data()));
    EXPECT_TRUE((minus * plus).isIdentity(1e-9));
  }
}

TEST(PoseFactors, HaveTheGradientOfTheirCost) {
  std::mt19937 random{6};
  std::uniform_real_distribution<double> any{-1, 1};
  const Pose first = any_pose(random);
  Twist small;
  for (double& value : small) value = 0.01 * any(random);
  const Pose second = exp(small) * first;
  const Pose prior = exp(-small) * first;
  PoseCovariance root;
  for (double& value : root.reshaped()) value = any(random);
  const PoseCovariance information = root * root.transpose() + PoseCovariance::Identity();
  expect_gradient(adjust::PosePrior{prior, information}, {adjust::to_block(first)});
  std::vector<adjust::PlaneMatch> matches;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d p{any(random), any(random), 2 + any(random)};
    const Eigen::Vector3d normal = Eigen::Vector3d{any(random), any(random), any(random)}.normalized();
    matches.push_back({p, Eigen::Hyperplane<double, 3>{normal, p + 0.01 * any(random) * normal}, 0.002, 0});
  }
  const auto held = adjust::held_by(adjust::sum_matches(matches, second * first.inverse(), 0), 2);
  EXPECT_EQ(held.count, 6);
  expect_gradient(adjust::MatchFactor{matches, 0, held}, {adjust::to_block(first), adjust::to_block(second)});
  expect_gradient(adjust::MatchFactor{matches, second, 0.02, held}, {adjust::to_block(first)});
}

TEST(JointPoses, HoldEachOtherWhereTheModelShowsLittle) {
  const auto found = compare(room(false), 0.003, 0.003, 5);
  EXPECT_LT(found.joint.relative_m, 0.5 * found.registered.relative_m);
  EXPECT_LT(found.joint.relative_m, 0.25 * found.tracked.relative_m);
  EXPECT_LT(found.joint.surface_m, 0.8 * found.registered.surface_m);
}

TEST(JointPoses, AreNotWorseThanEachFrameAloneWhereTheModelShowsMuch) {
  const auto found = compare(room(true), 0.003, 0.003, 5);
  EXPECT_LT(found.joint.relative_m, found.registered.relative_m);
  EXPECT_LT(found.joint.surface_m, 1.05 * found.registered.surface_m);
}

TEST(JointPoses, DoNoHarmToPosesThatAreRight) {
  for (const bool is_modelled : {false, true}) {
    const auto found = compare(room(is_modelled), 0.0003, 0.0003, 5);
    EXPECT_EQ(found.worse, 0);
    EXPECT_LT(found.joint.surface_m, found.tracked.surface_m + 0.0001);
  }
}

TEST(JointPoses, KeepWhatNothingHolds) {
  // A bare corridor along z: where along it the frames stand nobody can tell.
  const std::vector<Box> corridor{{{-1, 1, -5}, {1, 1.1, 50}, 1},
                                  {{-1, -1.1, -5}, {1, -1, 50}, 2},
                                  {{-1.1, -1, -5}, {-1, 1, 50}, 3},
                                  {{1, -1, -5}, {1.1, 1, 50}, 4}};
  Frames frames{corridor, 4, 0.002, 0.002, 3};
  for (std::size_t i = 0; i < 4; ++i) {
    Twist error;
    error << 0.002, -0.001, 0.003 * static_cast<double>(i), 0.001, 0, 0;
    frames.depths[i] = boxes::measure(corridor, kCamera, Pose::Identity(), kKinect, static_cast<unsigned>(i));
    frames.tracked[i].T_camera_world = exp(error);
  }
  frames.comparison = frames.expected_from(frames.tracked[0].T_camera_world);
  const auto joint = refine_poses(frames.tracked, kCamera, kKinect);
  ASSERT_FALSE(joint.refused) << *joint.refused;
  EXPECT_EQ(joint.held_by_model, 5);
  EXPECT_LT(joint.held_by_frames, 6);
  for (std::size_t i = 0; i < 4; ++i) {
    const Twist left = log(joint.T_camera_world[i]);
    EXPECT_LT(left.head<2>().norm(), 0.0011) << i << ": half of what the tracker was off";
    EXPECT_NEAR(left[2], 0.003 * static_cast<double>(i), 0.0007) << i;
  }
}

TEST(JointPoses, RefuseMoreThanAPosesOwnUncertainty) {
  Frames frames{room(true), 4, 0.001, 0.001, 4};
  Twist error = Twist::Zero();
  error[0] = 0.02;
  frames.tracked[2].T_camera_world = exp(error) * frames.T_camera_world[2];
  const auto joint = refine_poses(frames.tracked, kCamera, kKinect);
  ASSERT_TRUE(joint.refused);
  EXPECT_NE(joint.refused->find("frame 3 of 4"), std::string::npos) << *joint.refused;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(joint.T_camera_world[i].matrix(), frames.tracked[i].T_camera_world.matrix());
  }
}

TEST(JointPoses, RefuseWhereNothingIsToBeSaid) {
  Frames frames{room(true), 3, 0.001, 0.001, 5};
  auto exact = frames.tracked;
  for (auto& frame : exact) frame.covariance.setZero();
  EXPECT_EQ(refine_poses(exact, kCamera, kKinect).refused, "the poses count as exact");
  for (auto& depth : frames.depths) {
    for (auto& z : depth.pixels()) z = 0;
  }
  EXPECT_EQ(refine_poses(frames.tracked, kCamera, kKinect).refused, "the frames show nothing flat in common");
}

TEST(JointPoses, ExactOnesStayAndHoldTheOthers) {
  Frames frames{room(false), 4, 0.003, 0.003, 6};
  frames.tracked[0].T_camera_world = frames.T_camera_world[0];
  frames.tracked[0].covariance.setZero();
  frames.comparison = frames.expected_from(frames.T_camera_world[0]);
  const auto joint = refine_poses(frames.tracked, kCamera, kKinect);
  ASSERT_FALSE(joint.refused) << *joint.refused;
  EXPECT_TRUE(joint.T_camera_world[0].isApprox(frames.T_camera_world[0], 1e-9));
  EXPECT_LT(error_of(frames, joint.T_camera_world).relative_m, 0.002);
}

}  // namespace
}  // namespace meshloop
