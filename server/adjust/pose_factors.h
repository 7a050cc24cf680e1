#pragma once
// What Ceres needs to know of camera poses: how they move, what the tracker says of them, and what planes say of two.
#include <ceres/cost_function.h>
#include <ceres/manifold.h>

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "common/geometry/pose.h"

namespace meshloop::adjust {

/// A pose as Ceres holds it: quaternion (x, y, z, w), then translation.
using PoseBlock = std::array<double, 7>;
[[nodiscard]] PoseBlock to_block(const Pose& pose);
[[nodiscard]] Pose to_pose(const double* block);

/// Steps are twists that act on the left: exp(xi) T, in the frame that PoseCovariance is in.
class PoseManifold final : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return 7; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// The residual L^T log(T T_prior^-1), where L L^T is the information.
class PosePrior final : public ceres::CostFunction {
 public:
  PosePrior(const Pose& prior, const PoseCovariance& information);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  Pose prior_inverse_;
  PoseCovariance root_;
};

/// A point of one view and the plane that it should lie on, of another view or of the model.
struct PlaneMatch {
  Eigen::Vector3d point;
  Eigen::Hyperplane<double, 3> plane;
  double sigma_m = 0;
  /// Of the plane's normal, radians squared; 0 of the model's.
  double normal_variance = 0;
};

/// All matches between two frames, weighed at some relative pose: their robust cost, how they pull and hold it.
struct MatchSums {
  PoseCovariance information = PoseCovariance::Zero();
  Twist pull = Twist::Zero();
  double cost = 0;
  /// Of squares of the distances in metres, of those that count, and of their weights.
  double weighted_squares = 0;
  double weight = 0;
  /// Of the normals, by the same weights.
  double weighted_normal_variance = 0;
  int agreeing = 0;
};
/// Geman and McClure's loss: r / sqrt(1 + (r / c)^2) for a distance of r sigma, with c = max(3, cut_m in sigma).
/// `T_plane_point` maps points to the planes' frame; twists act on its left.
[[nodiscard]] MatchSums sum_matches(const std::vector<PlaneMatch>& matches, const Pose& T_plane_point, double cut_m);

/// Directions of a relative pose that these matches hold, as a projector: those along which the mean square of the
/// normals is above 0.0005 more than one and a half times what their noise alone makes of it; rotations by the way of
/// a point at `depth_m`.
struct HeldDirections {
  PoseCovariance projector = PoseCovariance::Zero();
  int count = 0;
};
[[nodiscard]] HeldDirections held_by(const MatchSums& sums, double depth_m);

/// All matches between two views, or a view and the model, as one residual of seven numbers with the same cost,
/// gradient and information (of Gauss and Newton) as all single ones: the optimisation has as many residuals as pairs,
/// not as matches. Directions that the matches do not hold have no gradient.
class MatchFactor final : public ceres::CostFunction {
 public:
  /// To planes of the model, given in a frame that stands still.
  MatchFactor(std::vector<PlaneMatch> matches, const Pose& T_plane_world, double cut_m, const HeldDirections& held);
  /// To planes of the second of its two views.
  MatchFactor(std::vector<PlaneMatch> matches, double cut_m, const HeldDirections& held);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  std::vector<PlaneMatch> matches_;
  Pose T_plane_world_ = Pose::Identity();
  bool is_between_views_;
  double cut_m_;
  PoseCovariance projector_;
};

}  // namespace meshloop::adjust
