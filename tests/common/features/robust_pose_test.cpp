#include "common/features/robust_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <random>

#include "plane_scene.h"

namespace meshloop {
namespace {

struct Problem {
  std::vector<PointObservation> points;
  Pose T_camera_world = Pose::Identity();
};

// Points in a room of 2 x 1.5 x 1 m in front of the camera; a share of them at random pixels.
Problem make_problem(unsigned seed, int count, double noise_px, double outliers) {
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> unit{-1, 1};
  std::normal_distribution<double> noise{0, noise_px};
  const Camera camera = test::vga_camera();
  Problem problem;
  const Eigen::Vector3d eye{unit(random) * 0.5, unit(random) * 0.5, -2};
  problem.T_camera_world = look_at(eye, {unit(random) * 0.1, unit(random) * 0.1, 0}, {0, -1, 0}).inverse();
  for (int i = 0; i < count; ++i) {
    PointObservation point;
    point.p_world = {unit(random), unit(random) * 0.75, unit(random) * 0.5};
    point.pixel =
        camera.project(problem.T_camera_world * point.p_world) + Eigen::Vector2d{noise(random), noise(random)};
    point.sigma_px = std::max(noise_px, 0.05);
    if (i < outliers * count) point.pixel = {319.5 + 320 * unit(random), 239.5 + 240 * unit(random)};
    problem.points.push_back(point);
  }
  return problem;
}

Pose disturbed(const Pose& pose, double shift_m, double angle) {
  Twist xi;
  xi << shift_m, -shift_m, shift_m, angle, angle, -angle;
  return exp(xi) * pose;
}

double shift_between(const Pose& a, const Pose& b) {
  return (a.inverse().translation() - b.inverse().translation()).norm();
}

TEST(Reprojection, JacobianAgreesWithCentralDifferences) {
  const Camera camera = test::vga_camera();
  const Problem problem = make_problem(1, 20, 1, 0);
  constexpr double kStep = 1e-6;
  for (const PointObservation& point : problem.points) {
    const ReprojectionTerm term = reprojection(point, camera, problem.T_camera_world);
    for (int k = 0; k < 6; ++k) {
      const Twist step = Twist::Unit(k) * kStep;
      const Eigen::Vector2d slope = (reprojection(point, camera, exp(step) * problem.T_camera_world).residual -
                                     reprojection(point, camera, exp(Twist{-step}) * problem.T_camera_world).residual) /
                                    (2 * kStep);
      EXPECT_LT((slope - term.jacobian.col(k)).norm(), 1e-4) << "column " << k;
    }
  }
}

TEST(RefinePose, IsExactWithoutNoise) {
  const Problem problem = make_problem(2, 50, 0, 0);
  const auto pose = refine_pose(problem.points, test::vga_camera(), disturbed(problem.T_camera_world, 0.05, 0.05), {});
  ASSERT_TRUE(pose);
  EXPECT_LT(log(pose->T_camera_world * problem.T_camera_world.inverse()).norm(), 1e-8);
  EXPECT_EQ(pose->inliers, 50);
  EXPECT_LT(pose->rms_px, 1e-5);
}

TEST(RefinePose, WithstandsFortyPercentOutliers) {
  const Camera camera = test::vga_camera();
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Problem problem = make_problem(seed, 100, 0.3, 0.4);
    const auto pose = refine_pose(problem.points, camera, disturbed(problem.T_camera_world, 0.01, 0.01), {});
    ASSERT_TRUE(pose) << "seed " << seed;
    EXPECT_LT(shift_between(pose->T_camera_world, problem.T_camera_world), 0.005) << "seed " << seed;
    EXPECT_GE(pose->inliers, 60);
    EXPECT_LE(pose->inliers, 63);
    for (std::size_t i = 40; i < 100; ++i) EXPECT_TRUE(pose->inlier[i]);
  }
}

double mean_squared_error(int seeds, double noise_px, double stated_px, double outliers) {
  double sum = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Problem problem = make_problem(static_cast<unsigned>(seed), 60, noise_px, outliers);
    for (PointObservation& point : problem.points) point.sigma_px = stated_px;
    const auto pose = refine_pose(problem.points, test::vga_camera(), problem.T_camera_world, {});
    if (!pose) return std::numeric_limits<double>::infinity();
    const Twist error = log(pose->T_camera_world * problem.T_camera_world.inverse());
    sum += error.dot(pose->covariance.ldlt().solve(error));
  }
  return sum / seeds;
}

// The mean of n squared errors over their covariance is chi-square with 6 n degrees of freedom over n: 6 +- 3 sqrt(12 /
// n).
TEST(RefinePose, CovarianceFitsTheErrors) {
  constexpr int kSeeds = 400;
  const double bound = 3 * std::sqrt(12.0 / kSeeds);
  EXPECT_NEAR(mean_squared_error(kSeeds, 0.5, 0.5, 0), 6, bound);
  EXPECT_NEAR(mean_squared_error(kSeeds, 0.5, 0.5, 0.3), 6, bound + 0.5);
}

TEST(RefinePose, CovarianceGrowsWithNoiseBeyondTheStated) {
  EXPECT_NEAR(mean_squared_error(400, 0.6, 0.2, 0), 6, 1);
}

TEST(RefinePose, CovarianceNeverBelowTheStatedNoise) {
  EXPECT_LT(mean_squared_error(100, 0.1, 1, 0), 0.2);
}

TEST(RefinePose, NothingForPointsOnALine) {
  const Camera camera = test::vga_camera();
  const Pose T_camera_world = look_at({0, 0, -2}, {0, 0, 0}, {0, -1, 0}).inverse();
  std::vector<PointObservation> points;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p{-0.5 + i / 30.0, 0.2 * i / 30.0, 0.1};
    points.push_back({p, camera.project(T_camera_world * p), 1});
  }
  EXPECT_FALSE(refine_pose(points, camera, T_camera_world, {}));
  EXPECT_FALSE(find_pose(points, camera, {}));
}

TEST(RefinePose, NothingForOnePointManyTimes) {
  const Camera camera = test::vga_camera();
  const Pose T_camera_world = look_at({0, 0, -2}, {0, 0, 0}, {0, -1, 0}).inverse();
  const std::vector<PointObservation> points(
      20, {{0.1, 0.2, 0}, camera.project(T_camera_world * Eigen::Vector3d{0.1, 0.2, 0}), 1});
  EXPECT_FALSE(refine_pose(points, camera, T_camera_world, {}));
  EXPECT_FALSE(find_pose(points, camera, {}));
}

TEST(RefinePose, NothingForTooFewOrBrokenPoints) {
  const Camera camera = test::vga_camera();
  Problem problem = make_problem(3, 11, 0.3, 0);
  EXPECT_FALSE(refine_pose(problem.points, camera, problem.T_camera_world, {}));
  EXPECT_FALSE(refine_pose({}, camera, problem.T_camera_world, {0, 0, 5}));
  problem = make_problem(3, 30, 0.3, 0);
  Pose nan = problem.T_camera_world;
  nan.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(refine_pose(problem.points, camera, nan, {}));
  problem.points[5].sigma_px = 0;
  EXPECT_FALSE(refine_pose(problem.points, camera, problem.T_camera_world, {}));
  problem.points[5].sigma_px = 1;
  problem.points[5].p_world.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(refine_pose(problem.points, camera, problem.T_camera_world, {}));
  EXPECT_FALSE(find_pose(problem.points, camera, {}));
}

TEST(RefinePose, IgnoresPointsBehindTheCamera) {
  const Camera camera = test::vga_camera();
  Problem problem = make_problem(4, 40, 0.3, 0);
  problem.points[0].p_world = problem.T_camera_world.inverse() * Eigen::Vector3d{0.1, 0.1, -1};
  const auto pose = refine_pose(problem.points, camera, problem.T_camera_world, {});
  ASSERT_TRUE(pose);
  EXPECT_FALSE(pose->inlier[0]);
  EXPECT_EQ(pose->inliers, 39);
}

TEST(FindPose, NeedsNoStartWithFortyPercentOutliers) {
  const Camera camera = test::vga_camera();
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Problem problem = make_problem(seed, 100, 0.3, 0.4);
    const auto pose = find_pose(problem.points, camera, {});
    ASSERT_TRUE(pose) << "seed " << seed;
    EXPECT_LT(shift_between(pose->T_camera_world, problem.T_camera_world), 0.005) << "seed " << seed;
  }
}

TEST(FindPose, GivesTheSameForTheSameInput) {
  const Problem problem = make_problem(6, 80, 0.5, 0.5);
  const auto first = find_pose(problem.points, test::vga_camera(), {});
  const auto second = find_pose(problem.points, test::vga_camera(), {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_camera_world.matrix(), second->T_camera_world.matrix());
}

TEST(FindPose, WorksOnAPlane) {
  const Camera camera = test::vga_camera();
  Problem problem = make_problem(7, 80, 0.3, 0.2);
  for (std::size_t i = 16; i < problem.points.size(); ++i) {
    problem.points[i].p_world.z() = 0;
    problem.points[i].pixel = camera.project(problem.T_camera_world * problem.points[i].p_world);
  }
  const auto pose = find_pose(problem.points, camera, {});
  ASSERT_TRUE(pose);
  EXPECT_LT(shift_between(pose->T_camera_world, problem.T_camera_world), 0.001);
}

TEST(FindPose, NothingWhenAllPointsAreWrong) {
  const Problem problem = make_problem(8, 100, 0.3, 1);
  EXPECT_FALSE(find_pose(problem.points, test::vga_camera(), {}));
}

}  // namespace
}  // namespace meshloop
