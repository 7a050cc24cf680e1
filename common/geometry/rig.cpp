#include "common/geometry/rig.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace meshloop {
namespace {

template <class Matrix>
bool is_covariance(const Matrix& matrix) {
  if (!matrix.allFinite() || !matrix.isApprox(matrix.transpose(), 1e-9)) return false;
  const auto eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix>{matrix, Eigen::EigenvaluesOnly}.eigenvalues();
  return eigenvalues.minCoeff() >= -1e-9 * eigenvalues.cwiseAbs().maxCoeff();
}

}  // namespace

Status validate(const Rig& rig) {
  if (auto ok = validate(rig.color); !ok) return fail("color", ok.error());
  if (auto ok = validate(rig.depth); !ok) return fail("depth", ok.error());
  if (!std::isfinite(rig.depth_scale) || rig.depth_scale <= 0) return fail("depth_scale must be positive");
  if (rig.depth_scale > 1) {
    return fail(
        fmt::format("depth_scale is {} metres per unit, and must be at most 1 (with {} units per metre say {:.3g})",
                    rig.depth_scale, rig.depth_scale, 1 / rig.depth_scale));
  }
  if (!is_rigid(rig.T_depth_color)) return fail("T_depth_color is not a rigid transform");
  if (!is_covariance(rig.covariance.depth_intrinsics)) {
    return fail("the covariance of the depth intrinsics must be symmetric, without negative eigenvalues");
  }
  if (!is_covariance(rig.covariance.T_depth_color)) {
    return fail("the covariance of T_depth_color must be symmetric, without negative eigenvalues");
  }
  return {};
}

}  // namespace meshloop
