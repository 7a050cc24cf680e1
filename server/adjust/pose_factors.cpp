#include "server/adjust/pose_factors.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace meshloop::adjust {
namespace {

constexpr double kLeastCut_sigmas = 3;
/// A direction is held when the mean square of the planes' normals along it is more than this.
constexpr double kHeld = 0.0005;
/// And so many times what the noise of the normals makes of it.
constexpr double kAboveNoise = 1.5;

using Matrix6 = PoseCovariance;
using Jacobian7 = Eigen::Map<Eigen::Matrix<double, 7, 7, Eigen::RowMajor>>;
using ToAmbient = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;

Eigen::Map<const Eigen::Quaterniond> rotation_of(const double* block) {
  return Eigen::Map<const Eigen::Quaterniond>{block};
}
Eigen::Map<const Eigen::Vector3d> translation_of(const double* block) {
  return Eigen::Map<const Eigen::Vector3d>{block + 4};
}

/// How a twist changes when it acts on the other side: T exp(xi) = exp(Ad(T) xi) T (Barfoot 2017, equation 7.48).
Matrix6 adjoint(const Pose& pose) {
  Matrix6 result = Matrix6::Zero();
  result.topLeftCorner<3, 3>() = result.bottomRightCorner<3, 3>() = pose.linear();
  result.topRightCorner<3, 3>() = skew(pose.translation()) * pose.linear();
  return result;
}

/// d log(exp(delta) exp(xi)) / d delta, to second order (Barfoot 2017, equations 7.79 and 7.80).
Matrix6 inverse_left_jacobian(const Twist& xi) {
  Matrix6 ad = Matrix6::Zero();
  ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = skew(xi.tail<3>());
  ad.topRightCorner<3, 3>() = skew(xi.head<3>());
  return Matrix6::Identity() - ad / 2 + ad * ad / 12;
}

ToAmbient minus_jacobian(const double* x) {
  ToAmbient result;
  PoseManifold{}.MinusJacobian(x, result.data());
  return result;
}

}  // namespace

PoseBlock to_block(const Pose& pose) {
  PoseBlock block;
  Eigen::Map<Eigen::Quaterniond>{block.data()} = Eigen::Quaterniond{pose.linear()}.normalized();
  Eigen::Map<Eigen::Vector3d>{block.data() + 4} = pose.translation();
  return block;
}

Pose to_pose(const double* block) {
  return make_pose(translation_of(block), rotation_of(block).normalized());
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseBlock moved = to_block(exp(Eigen::Map<const Twist>{delta}) * to_pose(x));
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J{jacobian};
  const auto q = rotation_of(x);
  J.setZero();
  J.block<3, 3>(0, 3) = (q.w() * Eigen::Matrix3d::Identity() - skew(q.vec())) / 2;
  J.block<1, 3>(3, 3) = -q.vec().transpose() / 2;
  J.block<3, 3>(4, 0).setIdentity();
  J.block<3, 3>(4, 3) = -skew(translation_of(x));
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<Twist>{y_minus_x} = log(to_pose(y) * to_pose(x).inverse());
  return true;
}

bool PoseManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<ToAmbient> J{jacobian};
  const auto q = rotation_of(x);
  Eigen::Matrix<double, 3, 4> turn;
  turn << 2 * (q.w() * Eigen::Matrix3d::Identity() + skew(q.vec())), -2 * q.vec();
  J.setZero();
  J.block<3, 4>(3, 0) = turn;
  J.block<3, 4>(0, 0) = skew(translation_of(x)) * turn;
  J.block<3, 3>(0, 4).setIdentity();
  return true;
}

PosePrior::PosePrior(const Pose& prior, const PoseCovariance& information)
    : prior_inverse_{prior.inverse()}, root_{Eigen::LLT<Matrix6>{information}.matrixU()} {
  set_num_residuals(6);
  mutable_parameter_block_sizes()->push_back(7);
}

bool PosePrior::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Twist xi = log(to_pose(parameters[0]) * prior_inverse_);
  Eigen::Map<Twist>{residuals} = root_ * xi;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<ToAmbient>{jacobians[0]} = root_ * inverse_left_jacobian(xi) * minus_jacobian(parameters[0]);
  }
  return true;
}

MatchSums sum_matches(const std::vector<PlaneMatch>& matches, const Pose& T_plane_point, double cut_m) {
  MatchSums sums;
  for (const auto& match : matches) {
    const Eigen::Vector3d p = T_plane_point * match.point;
    const double r = match.plane.signedDistance(p) / match.sigma_m;
    const double cut = std::max(kLeastCut_sigmas, cut_m / match.sigma_m);
    const double shrink = 1 / (1 + r * r / (cut * cut));
    const double slope = shrink * std::sqrt(shrink) / match.sigma_m;
    Twist along;
    along << match.plane.normal(), p.cross(match.plane.normal());
    along *= slope;
    sums.information.selfadjointView<Eigen::Lower>().rankUpdate(along);
    sums.pull += along * (r * std::sqrt(shrink));
    sums.cost += r * r * shrink;
    sums.weight += slope * slope;
    sums.weighted_normal_variance += slope * slope * match.normal_variance;
    sums.weighted_squares += slope * slope * r * r * match.sigma_m * match.sigma_m;
    sums.agreeing += std::abs(r) < cut ? 1 : 0;
  }
  sums.information = Matrix6{sums.information.selfadjointView<Eigen::Lower>()};
  return sums;
}

HeldDirections held_by(const MatchSums& sums, double depth_m) {
  HeldDirections held;
  if (!(sums.weight > 0)) return held;
  Twist scale;
  scale << 1, 1, 1, 1 / depth_m, 1 / depth_m, 1 / depth_m;
  const double least = kHeld + kAboveNoise * sums.weighted_normal_variance / sums.weight;
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver{scale.asDiagonal() * sums.information * scale.asDiagonal() /
                                                      sums.weight};
  for (int i = 0; i < 6; ++i) {
    if (solver.eigenvalues()[i] <= least) continue;
    const Twist direction = solver.eigenvectors().col(i);
    held.projector += direction.cwiseProduct(scale) * direction.cwiseQuotient(scale).transpose();
    ++held.count;
  }
  return held;
}

MatchFactor::MatchFactor(std::vector<PlaneMatch> matches, const Pose& T_plane_world, double cut_m,
                         const HeldDirections& held)
    : matches_{std::move(matches)},
      T_plane_world_{T_plane_world},
      is_between_views_{false},
      cut_m_{cut_m},
      projector_{held.projector} {
  set_num_residuals(7);
  mutable_parameter_block_sizes()->push_back(7);
}

MatchFactor::MatchFactor(std::vector<PlaneMatch> matches, double cut_m, const HeldDirections& held)
    : matches_{std::move(matches)}, is_between_views_{true}, cut_m_{cut_m}, projector_{held.projector} {
  set_num_residuals(7);
  mutable_parameter_block_sizes()->assign({7, 7});
}

bool MatchFactor::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Pose T_plane_world = is_between_views_ ? to_pose(parameters[1]) : T_plane_world_;
  const Pose T_plane_point = T_plane_world * to_pose(parameters[0]).inverse();
  const MatchSums sums = sum_matches(matches_, T_plane_point, cut_m_);
  // Seven residuals r and their Jacobian J, so that J^T J is the information, J^T r the pull, and r^T r the cost.
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver{sums.information};
  Eigen::Matrix<double, 7, 6> J = Eigen::Matrix<double, 7, 6>::Zero();
  Eigen::Map<Eigen::Matrix<double, 7, 1>> r{residuals};
  r.setZero();
  for (int i = 0; i < 6; ++i) {
    if (!(solver.eigenvalues()[i] > 1e-9 * solver.eigenvalues()[5])) continue;
    const double root = std::sqrt(solver.eigenvalues()[i]);
    J.row(i) = root * solver.eigenvectors().col(i).transpose();
    r[i] = solver.eigenvectors().col(i).dot(sums.pull) / root;
  }
  r[6] = std::sqrt(std::max(0.0, sums.cost - r.head<6>().squaredNorm()));
  if (jacobians == nullptr) return true;
  const Eigen::Matrix<double, 7, 6> held = J * projector_;
  if (jacobians[0] != nullptr) {
    Jacobian7{jacobians[0]} = -held * adjoint(T_plane_point) * minus_jacobian(parameters[0]);
  }
  if (is_between_views_ && jacobians[1] != nullptr) Jacobian7{jacobians[1]} = held * minus_jacobian(parameters[1]);
  return true;
}

}  // namespace meshloop::adjust
